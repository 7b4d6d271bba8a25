// Mixer (Eq 4) and its inverse under limits. Why: who yields at saturation is stated once, here:
// roll/pitch torque first (direction kept), then total thrust, then yaw. Closed form, never NaN, never outside limits.
#pragma once
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

struct Allocation {
  RotorCommands rotors;
  Saturation cut;
};

/// Four rotor thrusts inside [thrust_min, thrust_max] that give the wrench, or the part of it that fits.
/// A wrench that is not finite gives zero torque and hover-neutral thrust (limits still hold).
Allocation allocate(const Wrench& wrench, const Vehicle& vehicle);

/// The wrench that four thrusts give (Eq 4).
Wrench mix(const RotorCommands& rotors, const Vehicle& vehicle);

}  // namespace halfroll
