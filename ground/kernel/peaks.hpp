// What happens between the samples. Why: a force may stick out of its limits between two of them; asking a little more
// at the two samples around each such peak costs hundredths of a percent where shrinking all limits or slowing down all
// of the flight costs ten to a hundred times as much.
#pragma once
#include <array>
#include <vector>

#include "row_values.hpp"
#include "unknowns.hpp"

namespace halfroll::planner {

/// Looks at a piece on a grid several times as dense as its samples.
class FineGrid {
 public:
  FineGrid(const Constraints& constraints, int samples);

  /// Margins of a piece on the grid, kept for `least`; false if something is not finite.
  bool look(const Ends& ends, double duration, const PieceLimits& limits, const Bound* bounds);
  /// (intervals, bounds) Least margin from each sample to the next, by a parabola through the lowest three points.
  const Eigen::MatrixXd& least();
  /// Of the samples of a piece; the last may end at the first sample of the next piece.
  int intervals() const { return intervals_; }

 private:
  static constexpr int kFiner = 8;
  const Constraints& constraints_;
  SampleTable table_;
  int intervals_;
  FlatSamples flat_;
  Eigen::MatrixXd values_, margins_, least_;
};

/// The most negative margin of a trajectory at `samples` points of each piece.
double least_margin(const Trajectory& trajectory, const Problem& problem, const Constraints& constraints, int samples);

/// Smallest and largest thrust of each rotor [N] at `samples` points of each piece.
struct RotorRange {
  std::array<double, 4> low, high;
};
RotorRange rotor_range(const Trajectory& trajectory, const Constraints& constraints, int samples);

}  // namespace halfroll::planner
