// The vehicle as the firmware knows it. Why: no number of any vehicle stands in code; they come from vehicles/*.toml.
#pragma once
#include "core/types.hpp"

namespace halfroll {

enum class RotorKind : std::uint8_t { kVariablePitch = 0, kFixedPitch = 1 };

struct Vehicle {
  float mass = 0.F;             // [kg]
  Vec3 inertia = Vec3::Zero();  // [kg·m²], principal, body axes
  float arm = 0.F;              // [m], rotor to centre of mass (plus layout)
  float yaw_coefficient = 0.F;  // [m], rotor torque per thrust
  RotorKind rotor_kind = RotorKind::kVariablePitch;
  float thrust_min = 0.F;      // [N], per rotor; negative where blades can push down
  float thrust_max = 0.F;      // [N], per rotor
  float rotor_lag = 0.F;       // [s], first-order lag: of thrust (variable pitch), of speed when it rises (fixed pitch)
  float rotor_lag_down = 0.F;  // [s], fixed pitch: of speed when it falls
};

}  // namespace halfroll
