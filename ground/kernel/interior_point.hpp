// The solver: least total time inside the limits at samples. Why: every iterate lies inside (shifted) limits, so any
// of them is a flight, and the work of a step is linear in the number of pieces.
//
//   min sum T - mu sum log(g + e) - mu sum log(T - T_min)        g: margins at the samples,  e >= 0 shrinks to 0
//   (J' diag(z/(g+e)) J - share sum z g'' + times + damping) dx = -grad T + J' (mu + z e)/(g+e)        primal-dual
//   de = -e,   dz = (mu + z e)/(g+e) - z - z/(g+e) J dx
#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "constraints.hpp"
#include "unknowns.hpp"

namespace halfroll::planner {

/// Told the total time of the best flight so far [s], infinite while there is none; false: stop and take it.
using Progress = std::function<bool(double)>;

struct SolverSettings {
  int samples = 32;        // a piece, a multiple of Pack::kWidth
  double gap_start = 2.0;  // mu times the number of bounds, as a share of the total time: what the barrier costs
  double gap_end = 1e-3;
  double gap_factor = 0.15;
  double negligible = 3e-5;  // a Newton decrement below this share of the total time ends a stage of mu
  int iterations = 150;
  double duration_min = 0.012;  // [s] of a piece
  double shift = 0.02;          // margins below it start shifted by what they lack
  double curvature = 0.0;       // share of the constraints' curvature in the Hessian; 0: Gauss-Newton
  bool elastic = true;          // steps may leave limits while others are outside: longer, and together
  double spare = 0.0;           // relative margin to keep between the samples; 0: not looked at
};

struct Solution {
  Trajectory trajectory;
  bool feasible = false;  // at the samples, and between them if that was looked at
  bool interrupted = false;
  int iterations = 0;
  double push_price = 0.0;  // [s/N] by how much a lower least rotor thrust would shorten it, to first order
};

Solution minimise_time(const Problem& problem, const Constraints& constraints, const SolverSettings& settings,
                       const Progress& progress);

}  // namespace halfroll::planner
