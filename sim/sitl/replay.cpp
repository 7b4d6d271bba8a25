#include "sim/sitl/replay.hpp"

#include <cstdio>
#include <sstream>

#include "sim/sitl/bad_option.hpp"

namespace halfroll::sitl {
namespace {

Heard start_of(HeardReader& reader, const std::string& path) {
  auto first = reader.next();
  if (!first || first->call != Call::kStart) throw BadOption("--replay " + path + " ends before its firmware began");
  return *std::move(first);
}

void keep(InProcess& firmware, const Heard& start) {
  for (const Heard::Image& image : start.images) firmware.keep(image.slot, image.state, image.bytes);
}

std::unique_ptr<InProcess> firmware_at(const Heard& start) {
  auto firmware = std::make_unique<InProcess>("");
  keep(*firmware, start);
  return firmware;
}

}  // namespace

Options options_of_log(const std::string& replay, const std::string& log) {
  std::istringstream lines(HeardReader(replay).info("sitl_arguments"));
  std::vector<std::string> words;
  for (std::string word; std::getline(lines, word);) words.push_back(word);
  Options options = parse_options(words);
  options.replay = replay;
  options.log = log;
  return options;
}

Replay::Replay(const Options& options, const VehicleSetup& setup, const Version& version)
    : reader_(options.replay),
      first_(start_of(reader_, options.replay)),
      made_(firmware_at(first_)),
      firmware_(*made_),
      vehicle_(options, setup, version, std::move(made_), first_.wall_us) {}

void Replay::run() {
  while (const auto heard = reader_.next()) make(*heard);
  if (const auto last_us = reader_.last_step_us()) step_until(*last_us + kStepUs);
  if (!vehicle_.finish()) std::fprintf(stderr, "halfroll-sitl: the new log is not complete, is the disk full?\n");
}

/// Steps that heard nothing new are not in the log.
void Replay::step_until(std::uint64_t t_us) {
  LinkInputs in;
  in.wall_us = wall_us_;
  while (vehicle_.t_us() < t_us) vehicle_.step(in);
}

void Replay::make(const Heard& heard) {
  step_until(heard.t_us);
  if (heard.call == Call::kAskTime) return vehicle_.ask_time();
  if (heard.call == Call::kStart) {
    keep(firmware_, heard);
    return vehicle_.reboot(heard.wall_us);
  }
  std::vector<link::Datagram> datagrams;
  for (const auto& [from, bytes] : heard.datagrams) datagrams.push_back({from, bytes.data(), bytes.size()});
  LinkInputs in;
  in.rx = datagrams.data();
  in.rx_count = datagrams.size();
  in.wall_us = wall_us_ = heard.wall_us;
  if (heard.call == Call::kService) {
    vehicle_.service(in);
  } else {
    vehicle_.step(in);
  }
}

}  // namespace halfroll::sitl
