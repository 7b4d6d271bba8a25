// Repair without stretching. Why: between two samples a force may stick out of its limits; asking a little more at the
// two samples around each such peak, and solving on, costs hundredths of a percent where shrinking all limits or
// slowing down all of the flight costs ten to a hundred times as much.
#pragma once
#include <array>

#include "interior_point.hpp"

namespace halfroll::planner {

/// The most negative margin on a grid `kFiner` times as dense as the samples (relative, as Bound::margin).
/// Where a margin is below `spare`, the tightening of the two samples around it is raised.
double tighten_around_peaks(const Trajectory& trajectory, const Problem& problem, const Constraints& constraints,
                            int samples, double spare, Tightening& tightening);

/// The most negative margin of a trajectory at `samples` points of each piece.
double least_margin(const Trajectory& trajectory, const Problem& problem, const Constraints& constraints, int samples);

/// Smallest and largest thrust of each rotor [N] at `samples` points of each piece.
struct RotorRange {
  std::array<double, 4> low, high;
};
RotorRange rotor_range(const Trajectory& trajectory, const Constraints& constraints, int samples);

}  // namespace halfroll::planner
