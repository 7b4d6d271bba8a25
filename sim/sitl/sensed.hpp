// What the autopilot gets of the world. Why: the process and the Python module must give it the same.
#pragma once
#include "autopilot.hpp"
#include "sim/world.hpp"

namespace halfroll::sitl {

inline Inputs sensed(const sim::World& world) {
  Inputs in;
  in.measured = world.readings;
  if (world.battery.voltage > 0.0) {  // else as the autopilot has it: full
    in.battery = {static_cast<float>(world.battery.voltage), static_cast<float>(world.battery.charge)};
  }
  return in;
}

}  // namespace halfroll::sitl
