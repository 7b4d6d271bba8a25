// The host board: endpoints over real loopback sockets, storage in a real directory.
#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "boards/host/steady_clock.hpp"
#include "boards/host/storage.hpp"
#include "boards/host/udp_links.hpp"

using namespace halfroll;
using namespace halfroll::host;

namespace {

using Bytes = std::vector<std::uint8_t>;
const Bytes kFrame = {0xFD, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0};  // shortest MAVLink 2 frame

/// A ground station's socket on a port of the system's choice.
class Client {
 public:
  Client() : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in a{};
    a.sin_family = AF_INET;
    a.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof a;
    ::bind(socket_, reinterpret_cast<sockaddr*>(&a), size);
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&a), &size);
    port_ = ntohs(a.sin_port);
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() { ::close(socket_); }

  std::uint16_t port() const { return port_; }
  void send(std::uint16_t port, const Bytes& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(port);
    ::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
  }
  /// Bytes of the next datagram, 0 if there is none; `from` gets the sender's port.
  std::size_t receive(std::uint16_t* from = nullptr) const {
    std::uint8_t buffer[2048];
    sockaddr_in sender{};
    socklen_t size = sizeof sender;
    const ssize_t n =
        ::recvfrom(socket_, buffer, sizeof buffer, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&sender), &size);
    if (from != nullptr) *from = ntohs(sender.sin_port);
    return n < 0 ? 0 : static_cast<std::size_t>(n);
  }

 private:
  int socket_;
  std::uint16_t port_ = 0;
};

link::TxFrame frame_to(std::uint8_t link, std::uint8_t slot) {
  link::TxFrame frame;
  frame.to = {link, slot};
  frame.size = 12;
  return frame;
}

/// Links on free ports, their default peers, and the port of link A.
struct Loopback {
  Client station, gcs;
  UdpLinks links{"127.0.0.1", {{{0, station.port()}, {0, gcs.port()}}}};
  std::uint16_t port_a = 0;

  Loopback() {
    links.send(frame_to(0, 0));
    station.receive(&port_a);
  }
};

/// An empty directory that goes away with the test.
struct Folder {
  std::string path =
      (std::filesystem::temp_directory_path() / ("halfroll-storage-" + std::to_string(::getpid()))).string();
  Folder() { std::filesystem::remove_all(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

link::StorageRequest keep(link::StorageSlot slot, const Bytes& bytes) { return {slot, bytes.data(), bytes.size()}; }

}  // namespace

TEST_CASE("the default peer is slot 0, an unknown sender of a frame becomes slot 1") {
  Loopback l;
  const Client mavsdk;
  l.station.send(l.port_a, kFrame);
  mavsdk.send(l.port_a, kFrame);
  const auto& received = l.links.receive(0);
  REQUIRE(received.size() == 2);
  CHECK(received[0].from == link::Endpoint{0, 0});
  CHECK(received[1].from == link::Endpoint{0, 1});
  CHECK(Bytes(received[1].bytes, received[1].bytes + received[1].size) == kFrame);
}

TEST_CASE("a reply goes to the one who asked, a stream to everyone on its link") {
  Loopback l;
  const Client mavsdk;
  mavsdk.send(l.port_a, kFrame);
  l.links.receive(0);
  l.links.send(frame_to(0, 1));
  CHECK(mavsdk.receive() == 12);
  CHECK(l.station.receive() == 0);
  l.links.send(frame_to(0, link::kEveryone));
  CHECK(mavsdk.receive() == 12);
  CHECK(l.station.receive() == 12);
  CHECK(l.gcs.receive() == 0);
  l.links.send(frame_to(link::kAllLinks, link::kEveryone));
  CHECK(l.gcs.receive() == 12);
}

TEST_CASE("several frames go to each peer in as few datagrams as 1200 bytes allow") {
  Loopback l;
  l.links.send({frame_to(0, 0), frame_to(0, 1), frame_to(link::kAllLinks, link::kEveryone)});
  CHECK(l.station.receive() == 24);
  CHECK(l.gcs.receive() == 12);
  l.links.send(std::vector<link::TxFrame>(150, frame_to(0, 0)));
  CHECK(l.station.receive() == 1200);
  CHECK(l.station.receive() == 600);
  CHECK(l.station.receive() == 0);
}

TEST_CASE("noise makes no endpoint") {
  Loopback l;
  const Client noise;
  noise.send(l.port_a, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  noise.send(l.port_a, {0xFD, 200, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0});
  noise.send(l.port_a, {});
  CHECK(l.links.receive(0).empty());
}

TEST_CASE("eight clients are heard, a ninth after one has been silent for 30 s") {
  Loopback l;
  std::vector<std::unique_ptr<Client>> clients;
  for (int i = 0; i < 9; ++i) {
    clients.push_back(std::make_unique<Client>());
    clients.back()->send(l.port_a, kFrame);
  }
  CHECK(l.links.receive(1000).size() == 8);
  clients[8]->send(l.port_a, kFrame);
  CHECK(l.links.receive(30000000).empty());
  clients[8]->send(l.port_a, kFrame);
  CHECK(l.links.receive(30002000).size() == 1);
}

TEST_CASE("a taken port is named") {
  Loopback l;
  try {
    const UdpLinks second("127.0.0.1", {{{l.port_a, 1}, {0, 1}}});
    FAIL("bound twice");
  } catch (const PortInUse& taken) {
    CHECK(taken.port == l.port_a);
    CHECK(std::string(taken.what()).find(std::to_string(l.port_a)) != std::string::npos);
  }
  CHECK_THROWS_AS(UdpLinks("nowhere", {{{0, 1}, {0, 1}}}), std::runtime_error);
}

Bytes stored(const Storage& storage, link::StorageSlot slot) {
  const link::StoredImage image = storage.stored(slot);
  return {image.bytes, image.bytes + image.size};
}

void flip_a_byte(const std::string& path, std::streamoff offset) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekg(offset);
  const auto byte = static_cast<char>(file.get());
  file.seekp(offset);
  file.put(static_cast<char>(byte ^ 0x40));
}

TEST_CASE("what is stored is there after a restart") {
  const Folder folder;
  const Bytes params = {1, 2, 3}, mission = {4, 5};
  {
    Storage storage(folder.path);
    CHECK(stored(storage, link::StorageSlot::kParams).empty());
    CHECK(storage.write(keep(link::StorageSlot::kParams, {9})).ok);
    CHECK(storage.write(keep(link::StorageSlot::kParams, params)).ok);
    CHECK(storage.write(keep(link::StorageSlot::kMission, mission)).ok);
  }
  const Storage again(folder.path);
  CHECK(stored(again, link::StorageSlot::kParams) == params);
  CHECK(stored(again, link::StorageSlot::kMission) == mission);
  CHECK(again.stored(link::StorageSlot::kParams).state == link::StoredState::kSound);
}

TEST_CASE("a store with one corrupt copy starts with the other and says so, with two it is lost") {
  const Folder folder;
  {
    Storage storage(folder.path);
    CHECK(storage.write(keep(link::StorageSlot::kParams, {1})).ok);
    CHECK(storage.write(keep(link::StorageSlot::kParams, {2})).ok);
  }
  flip_a_byte(folder.path + "/params.1.bin", 32);
  CHECK(stored(Storage(folder.path), link::StorageSlot::kParams) == Bytes{1});
  CHECK(Storage(folder.path).stored(link::StorageSlot::kParams).state == link::StoredState::kOtherCopyDamaged);
  flip_a_byte(folder.path + "/params.0.bin", 3);
  CHECK(Storage(folder.path).stored(link::StorageSlot::kParams).state == link::StoredState::kLost);
}

TEST_CASE("a write that fails says so and keeps the old image") {
  const Folder folder;
  Storage storage(folder.path);
  CHECK(storage.write(keep(link::StorageSlot::kParams, {1})).ok);
  std::filesystem::remove(folder.path + "/params.1.bin");
  std::filesystem::create_directories(folder.path + "/params.1.bin");  // in the way of the other copy
  CHECK_FALSE(storage.write(keep(link::StorageSlot::kParams, {2})).ok);
  CHECK(stored(storage, link::StorageSlot::kParams) == Bytes{1});
  CHECK(stored(Storage(folder.path), link::StorageSlot::kParams) == Bytes{1});
}

TEST_CASE("without a directory nothing outlives the process, yet a reboot finds it") {
  Storage storage("");
  CHECK(storage.write(keep(link::StorageSlot::kMission, {7})).ok);
  CHECK(stored(storage, link::StorageSlot::kMission) == Bytes{7});
  CHECK(stored(Storage(""), link::StorageSlot::kMission).empty());
}

TEST_CASE("a file where the directory should be is refused") {
  const Folder folder;
  std::ofstream(folder.path) << "in the way";
  CHECK_THROWS_AS(Storage{folder.path}, std::runtime_error);
}

TEST_CASE("the clock does not run backwards") {
  const std::uint64_t before = wall_us();
  sleep_until(before + 1000);
  CHECK(wall_us() >= before + 1000);
}
