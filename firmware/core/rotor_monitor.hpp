// Is each rotor doing what it was told? Why: a weak or stuck rotor must bring the vehicle down while it can still land.
//
// Force along body up and angular acceleration say, by the mixer's inverse, what each rotor gives; the commands through
// the rotor's lag say what it should give. Both pass the same low-pass filter, so its delay cancels. A faulty rotor
// shows as an error that is large in one rotor alone: wind, an empty battery or a wrong mass spread over all, a torque
// from outside over a pair.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

class RotorMonitor {
 public:
  /// One millisecond. `given`: the commands that were in force until this sample.
  void step(const RotorCommands& given, const Vec3& w_WB_B, const Vec3& specific_force_B, const Vehicle& vehicle);

  /// The rotor (1..4) whose error is at least FD_ROTOR_ERR of the hover thrust, and twice any other's; 0: none.
  int suspect(const Vehicle& vehicle, const Params& params) const;

  void reset() { *this = RotorMonitor{}; }
  auto state() const { return std::tie(expected_, force_, rate_, gyroscopic_, error_, filtered_, started_); }

 private:
  std::array<float, 4> expected_ = {};  // through the rotor's lag: thrust (variable pitch), sqrt of it (fixed pitch)
  float force_ = 0.F;                   // [N], the rest filtered
  Vec3 rate_ = Vec3::Zero();
  Vec3 gyroscopic_ = Vec3::Zero();
  std::array<float, 4> error_ = {};  // [N], should give minus gives
  std::array<float, 4> filtered_ = {};
  bool started_ = false;
};

}  // namespace halfroll
