#include "peaks.hpp"

#include <algorithm>
#include <limits>

namespace halfroll::planner {
namespace {

/// (samples, bounds) margins of a piece.
Eigen::MatrixXd margins(const Trajectory& trajectory, int piece, const PieceLimits& limits,
                        const Constraints& constraints, const SampleTable& table) {
  FlatSamples flat;
  Eigen::MatrixXd values;
  sample_piece(trajectory.ends(piece), trajectory.durations[piece], table, flat);
  evaluate(constraints, limits, flat, values);
  Eigen::MatrixXd margin(values.rows(), static_cast<int>(constraints.bounds().size()));
  for (int b = 0; b < margin.cols(); ++b) {
    const Bound at = constraints.on_piece(b, limits);
    margin.col(b) = at.sign / at.scale * (values.col(at.row).array() - at.limit);
  }
  return margin;
}

/// Of the parabola through three equidistant values, the middle one the lowest.
double vertex(double left, double middle, double right) {
  const double bend = left - 2.0 * middle + right;
  return bend > 0.0 ? middle - (right - left) * (right - left) / (8.0 * bend) : middle;
}

}  // namespace

FineGrid::FineGrid(const Constraints& constraints, int samples)
    : constraints_(constraints),
      table_(samples * kFiner, constraints.limits_rates()),
      intervals_(constraints.limits_rates() ? samples - 1 : samples),
      least_(intervals_, static_cast<int>(constraints.bounds().size())) {}

bool FineGrid::look(const Ends& ends, double duration, const PieceLimits& limits, const Bound* bounds) {
  sample_piece(ends, duration, table_, flat_);
  evaluate(constraints_, limits, flat_, values_);
  margins_.resize(values_.rows(), least_.cols());
  for (int b = 0; b < least_.cols(); ++b) {
    const Bound& at = bounds[b];
    margins_.col(b) = at.sign / at.scale * (values_.col(at.row).array() - at.limit);
  }
  return values_.allFinite();
}

const Eigen::MatrixXd& FineGrid::least() {
  const int count = static_cast<int>(margins_.rows());
  least_.setConstant(std::numeric_limits<double>::infinity());
  for (int b = 0; b < least_.cols(); ++b) {
    const double* margin = margins_.col(b).data();
    for (int j = 0; j < count; ++j) {
      double low = margin[j];
      if (j > 0 && j + 1 < count && low <= margin[j - 1] && low <= margin[j + 1]) {
        low = vertex(margin[j - 1], low, margin[j + 1]);
      }
      double& least = least_(std::min(j * intervals_ / table_.intervals(), intervals_ - 1), b);
      least = std::min(least, low);
    }
  }
  return least_;
}

double least_margin(const Trajectory& trajectory, const Problem& problem, const Constraints& constraints, int samples) {
  const SampleTable table(samples, constraints.limits_rates());
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < trajectory.pieces(); ++k) {
    const Eigen::MatrixXd margin = margins(trajectory, k, problem.limits[k], constraints, table);
    if (!margin.allFinite()) return -std::numeric_limits<double>::infinity();
    least = std::min(least, margin.minCoeff());
  }
  return least;
}

RotorRange rotor_range(const Trajectory& trajectory, const Constraints& constraints, int samples) {
  const SampleTable table(samples, constraints.limits_rates());
  RotorRange range;
  range.low.fill(std::numeric_limits<double>::infinity());
  range.high.fill(-std::numeric_limits<double>::infinity());
  FlatSamples flat;
  Eigen::MatrixXd values;
  for (int k = 0; k < trajectory.pieces(); ++k) {
    sample_piece(trajectory.ends(k), trajectory.durations[k], table, flat);
    evaluate(constraints, {}, flat, values);
    for (int i = 0; i < 4; ++i) {  // the rotors are the first rows
      const auto thrust = values.col(constraints.limits().vertical ? 0 : i);
      range.low[i] = std::min(range.low[i], thrust.minCoeff());
      range.high[i] = std::max(range.high[i], thrust.maxCoeff());
    }
  }
  return range;
}

}  // namespace halfroll::planner
