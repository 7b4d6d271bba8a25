// Rotor thrusts at one point and their exact slopes. Why: the solver takes these four samples at a time, with the other
// limits; who asks for a single point gets them here, from the same formulas.
#pragma once
#include <array>

#include "inverse_dynamics.hpp"

namespace halfroll::planner {

struct RotorSlopes {
  std::array<double, 4> thrusts;           // [N], rotors left, rear, right, front
  std::array<FlatGradient<double>, 4> by;  // of each thrust, over the flat outputs
};

RotorSlopes rotor_slopes(const Flat<double>& flat, const Vehicle& vehicle);

}  // namespace halfroll::planner
