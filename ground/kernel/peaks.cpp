#include "peaks.hpp"

#include <algorithm>
#include <limits>

namespace halfroll::planner {
namespace {

constexpr int kFiner = 16;
constexpr double kGain = 1.1;  // over what was missed
constexpr double kPad = 1e-4;  // relative to a bound's scale

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

}  // namespace

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

double tighten_around_peaks(const Trajectory& trajectory, const Problem& problem, const Constraints& constraints,
                            int samples, double spare, Tightening& tightening) {
  const bool rates = constraints.limits_rates();
  const SampleTable table(samples * kFiner, rates);
  const int intervals = rates ? samples - 1 : samples;  // of the samples
  const int bounds = static_cast<int>(constraints.bounds().size());
  if (tightening.empty()) tightening.assign(problem.pieces(), Eigen::MatrixXd::Zero(samples, bounds));
  const Tightening before = tightening;
  double least = std::numeric_limits<double>::infinity();
  const auto ask = [&](int piece, int sample, int bound, double more) {
    if (sample == samples) ++piece, sample = 0;
    if (piece == problem.pieces()) return;
    double& now = tightening[piece](sample, bound);
    now = std::max(now, before[piece](sample, bound) + more);
  };
  for (int k = 0; k < trajectory.pieces(); ++k) {
    const Eigen::MatrixXd margin = margins(trajectory, k, problem.limits[k], constraints, table);
    for (int b = 0; b < bounds; ++b) {
      for (int j = 0; j < table.count(); ++j) {
        const double here = margin(j, b);
        least = std::min(least, here);
        if (here >= spare) continue;
        const double more = kGain * (spare - here) + kPad;
        const int i = std::min(j * intervals / table.intervals(), intervals - 1);
        ask(k, i, b, more);
        ask(k, i + 1, b, more);
      }
    }
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
