// From wanted thrust to rotor command. Why: fixed-pitch motors are slower than the attitude loop needs; their known
// lag is inverted here. Variable-pitch commands pass through.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

/// Motor model of each fixed-pitch rotor: speed in units of sqrt(thrust).
class RotorLagInverse {
 public:
  /// Commands that make the thrusts follow `wanted` LAG_COMP times faster than the motors do by themselves.
  RotorCommands step(const RotorCommands& wanted, const Vehicle& vehicle, const Params& params);
  void reset() { speed_ = {0.F, 0.F, 0.F, 0.F}; }
  auto state() const { return std::tie(speed_); }

 private:
  std::array<float, 4> speed_ = {0.F, 0.F, 0.F, 0.F};  // [sqrt N]
};

}  // namespace halfroll
