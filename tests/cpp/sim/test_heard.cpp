// What a firmware heard, through a log and back.
#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include "sim/sitl/bad_option.hpp"
#include "sim/sitl/heard.hpp"

using namespace halfroll;
using namespace halfroll::sitl;

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{7});
  return bytes;
}

struct File {
  std::string path = (std::filesystem::temp_directory_path() / "halfroll_heard_test.ulg").string();
  ~File() { std::remove(path.c_str()); }

  std::string content() const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void replace(const std::string& content) const {
    std::ofstream(path, std::ios::binary | std::ios::trunc).write(content.data(), static_cast<long>(content.size()));
  }
};

/// A start with one image, a step that hears a datagram of each size, and a question for the time.
void write(const std::string& path, const std::vector<Bytes>& heard) {
  Ulog ulog(path);
  ulog.info("sitl_arguments", "--seed\n7\n");
  const auto commands = ulog.add_topic("rotor_commands", "float[4] thrust;");
  HeardLog log(ulog);
  ulog.begin_data();
  const Bytes image = bytes_of(1000);
  log.image(0, link::StorageSlot::kMission, {link::StoredState::kSound, image.data(), image.size()});
  log.start(0, 1234);
  std::vector<link::Datagram> datagrams;
  for (const Bytes& bytes : heard) {
    datagrams.push_back({{1, static_cast<std::uint8_t>(datagrams.size())}, bytes.data(), bytes.size()});
  }
  LinkInputs in;
  in.wall_us = 99;
  in.rx = datagrams.data();
  in.rx_count = datagrams.size();
  log.call(5000, Call::kStep, in);
  LinkInputs nothing;
  nothing.wall_us = 99;
  log.call(6000, Call::kStep, nothing);  // is not written: nothing new
  log.ask_time(10000);
  ulog.begin(commands, 12000);
  for (int i = 0; i < 4; ++i) ulog.put(1.5F);
  ulog.end();
}

}  // namespace

TEST_CASE("what was heard is read back call by call, byte by byte") {
  const File file;
  const std::vector<Bytes> sent = {bytes_of(0), bytes_of(1), bytes_of(48), bytes_of(49), bytes_of(280), bytes_of(2048)};
  write(file.path, sent);
  HeardReader reader(file.path);
  CHECK(reader.info("sitl_arguments") == "--seed\n7\n");

  const auto start = reader.next();
  REQUIRE(start);
  CHECK(start->call == Call::kStart);
  CHECK(start->wall_us == 1234);
  REQUIRE(start->images.size() == 1);
  CHECK(start->images[0].slot == link::StorageSlot::kMission);
  CHECK(start->images[0].bytes == bytes_of(1000));

  const auto step = reader.next();
  REQUIRE(step);
  CHECK(step->t_us == 5000);
  CHECK(step->wall_us == 99);
  REQUIRE(step->datagrams.size() == sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) {
    CHECK(step->datagrams[i].bytes == sent[i]);
    CHECK(step->datagrams[i].from == link::Endpoint{1, static_cast<std::uint8_t>(i)});
  }

  CHECK(reader.next()->call == Call::kAskTime);
  CHECK(!reader.next());
  CHECK(reader.last_step_us() == 12000);
}

TEST_CASE("a log that is cut off anywhere gives the calls that are whole, or says what it lacks") {
  const File file;
  write(file.path, {bytes_of(100)});
  const std::string whole = file.content();
  std::size_t calls_before = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    file.replace(whole.substr(0, size));
    std::size_t calls = 0;
    try {
      HeardReader reader(file.path);
      while (reader.next()) ++calls;
    } catch (const BadOption& wrong) {
      CHECK(std::string(wrong.what()).find(file.path) != std::string::npos);
    }
    CHECK(calls >= calls_before);
    calls_before = calls;
  }
  CHECK(calls_before == 3);
}
