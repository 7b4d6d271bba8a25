// What a simulated flight leaves behind: truth, estimate, references and commands of every millisecond, as ULog.
// Why: one place names the topics and fields that readers rely on. World axes north-west-up, SI.
#pragma once
#include <cstdint>
#include <string>

#include "core/params.hpp"
#include "core/types.hpp"
#include "sim/sitl/status_text.hpp"
#include "sim/sitl/ulog.hpp"
#include "sim/world.hpp"

namespace halfroll::sitl {

/// Who flew in what.
struct FlightFacts {
  std::string version, vehicle, scenario;
  std::uint64_t seed = 0;
  bool lockstep = false;
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
};

class FlightLog {
 public:
  FlightLog(const std::string& path, const FlightFacts& facts, const Params& params);

  void add(const FlightRecord& record);
  /// Something the autopilot said.
  void say(std::uint64_t t_us, const SaidText& text) { ulog_.text(text.severity, t_us, text.line); }
  /// The last entry of a log that ends properly; false if anything could not be written.
  bool finish(const std::string& commands_sha256);

 private:
  static constexpr std::uint64_t kFlushUs = 500000;

  Ulog ulog_;
  Ulog::Topic truth_, commands_, estimate_, reference_, state_;
  std::uint64_t flushed_us_ = 0;
  int last_mode_ = -1, last_armed_ = -1;
};

}  // namespace halfroll::sitl
