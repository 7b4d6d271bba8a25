// A logged flight, flown again from what its firmware heard. Why: the same vehicle in the same world, hearing the same
// at the same instants, gives the same commands in every bit; where it does not, something has changed.
#pragma once
#include <string>

#include "sim/sitl/simulated_vehicle.hpp"

namespace halfroll::sitl {

/// How the flight in the log `replay` was started, to begin it again; `log`: where the new one is written, or "".
/// Throws BadOption.
Options options_of_log(const std::string& replay, const std::string& log);

/// Flies the log options.replay to its end, or as far as it goes.
class Replay {
 public:
  /// Throws BadOption for a log that cannot be flown again, std::runtime_error.
  Replay(const Options& options, const VehicleSetup& setup, const Version& version);

  void run();
  const SimulatedVehicle& vehicle() const { return vehicle_; }

 private:
  void step_until(std::uint64_t t_us);
  void make(const Heard& heard);

  HeardReader reader_;
  Heard first_;
  std::unique_ptr<InProcess> made_;  // until vehicle_ has it
  InProcess& firmware_;
  SimulatedVehicle vehicle_;
  std::uint64_t wall_us_ = 0;  // as last told
};

}  // namespace halfroll::sitl
