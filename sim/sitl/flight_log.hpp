// What a simulated flight leaves behind, as ULog: truth, estimate, references and commands, all that the firmware
// heard, and the same in PX4's words (px4_topics). Why: one place names the topics and fields that readers rely on.
// World axes north-west-up, SI. docs/logs.md lists them all.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/params.hpp"
#include "core/types.hpp"
#include "sim/sitl/heard.hpp"
#include "sim/sitl/px4_topics.hpp"
#include "sim/sitl/status_text.hpp"
#include "sim/sitl/ulog.hpp"
#include "sim/world.hpp"

namespace halfroll::sitl {

/// Who flew in what.
struct FlightFacts {
  std::string version, commit, vehicle, scenario;
  std::uint64_t seed = 0;
  bool lockstep = false;
  std::vector<std::string> arguments;  // that make this simulation again
  std::uint64_t unix_us = 0;           // at time 0
  link::Origin origin;
};

/// One millisecond: what was true when the sensors were read, and what the firmware made of it.
struct FlightRecord {
  std::uint64_t t_us = 0;
  const sim::World& truth;
  const Estimate& estimate;
  const Reference& reference;
  const RotorCommands& commands;
  std::uint8_t mode = 0;
  bool armed = false;
  std::uint32_t ground_frames = 0;  // of the ground station, so far
  const Params& params;
};

class FlightLog {
 public:
  FlightLog(const std::string& path, const FlightFacts& facts, const sim::Plant& plant, const Params& params);

  void add(const FlightRecord& record);
  HeardLog& heard() { return heard_; }
  /// Something the autopilot said.
  void say(std::uint64_t t_us, const SaidText& text) { ulog_.text(text.severity, t_us, text.line); }
  /// The last entry of a log that ends properly; false if anything could not be written.
  bool finish(const std::string& commands_sha256);

 private:
  static constexpr std::uint64_t kFlushUs = 100000, kEstimateUs = 4000, kLinkUs = 20000, kParamsUs = 100000;

  void add_changed_params(const Params& params);

  Ulog ulog_;
  Ulog::Topic truth_, commands_, estimate_, reference_, state_, link_;
  Params params_;  // as the log has them
  Px4Topics px4_;
  HeardLog heard_;
  std::uint64_t flushed_us_ = 0, ground_heard_us_ = 0;
  std::uint32_t ground_frames_ = 0;
  int last_mode_ = -1, last_armed_ = -1;
};

}  // namespace halfroll::sitl
