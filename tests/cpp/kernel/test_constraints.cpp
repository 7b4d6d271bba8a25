#include <doctest/doctest.h>

#include "flights.hpp"

namespace halfroll::planner {

// Every row's gradient against differences of its value by each flat output: central ones of two widths, whose leading
// error cancels.
TEST_CASE("the gradient of every limited quantity is that of its finite differences") {
  const Constraints constraints(paper_vehicle(), every_limit(), true);
  const SampleTable table(8);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Trajectory path = random_piece(seed);
    FlatSamples flat;
    sample_piece(path.ends(0), path.durations[0], table, flat);
    std::vector<Eigen::MatrixXd> slopes;
    differentiate(constraints, flat, slopes);
    for (std::size_t r = 0; r < constraints.rows().size(); ++r) {
      const auto& entries = constraints.rows()[r].entries;
      for (std::size_t e = 0; e < entries.size(); ++e) {
        const double step = 2e-4 * (1.0 + std::abs(flat[entries[e].order](0, entries[e].axis)));
        const int row = static_cast<int>(r);
        const auto moved = [&](double by) -> Eigen::ArrayXd {
          FlatSamples other = flat;
          other[entries[e].order].col(entries[e].axis).array() += by;
          Eigen::MatrixXd values;
          evaluate(constraints, other, values);
          return values.col(row);
        };
        const Eigen::ArrayXd narrow = (moved(step) - moved(-step)) / (2.0 * step);
        const Eigen::ArrayXd wide = (moved(2.0 * step) - moved(-2.0 * step)) / (4.0 * step);
        const Eigen::ArrayXd difference = (4.0 * narrow - wide) / 3.0;
        const Eigen::ArrayXd slope = slopes[r].col(static_cast<int>(e));
        const double rounding = 1e-13 * (1.0 + moved(0.0).abs().maxCoeff()) / step;
        INFO("seed ", seed, " row ", r, " entry ", e);
        CHECK((difference - slope).abs().maxCoeff() < 1e-6 * slope.abs().maxCoeff() + rounding);
      }
    }
  }
}

// Of a weighted sum of rows: differences of its gradient by each entry.
TEST_CASE("the curvature is the slope of the gradient") {
  const Constraints constraints(paper_vehicle(), every_limit(), false);
  const int rows = static_cast<int>(constraints.rows().size());
  const SampleTable table(4);
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(4, rows);
  for (int r = 0; r < rows; ++r) {
    if (constraints.rows()[r].entries.size() == kDynamicEntries) weights.col(r).setConstant(0.3 + 0.2 * r);
  }
  const auto gradient = [&](const FlatSamples& flat, int entry) {
    std::vector<Eigen::MatrixXd> slopes;
    differentiate(constraints, flat, slopes);
    double sum = 0.0;
    for (int r = 0; r < rows; ++r) sum += weights(0, r) == 0.0 ? 0.0 : weights(0, r) * slopes[r](0, entry);
    return sum;
  };
  for (unsigned seed = 0; seed < 5; ++seed) {
    FlatSamples flat;
    sample_piece(random_piece(seed).ends(0), 0.7, table, flat);
    Eigen::MatrixXd hessians;
    curvature(constraints, flat, weights, hessians);
    const double size = hessians.row(0).cwiseAbs().maxCoeff();
    for (int e = 0; e < kDynamicEntries; ++e) {
      const auto [axis, order] = dynamic_entry(e);
      const double step = 1e-5 * (1.0 + std::abs(flat[order](0, axis)));
      FlatSamples more = flat, less = flat;
      more[order](0, axis) += step;
      less[order](0, axis) -= step;
      for (int f = 0; f < kDynamicEntries; ++f) {
        CHECK(std::abs((gradient(more, f) - gradient(less, f)) / (2.0 * step) - hessians(0, dynamic_pair(e, f))) <
              1e-5 * size);
      }
    }
  }
}

TEST_CASE("a quantity that depends on an entry has that entry in its row") {
  const Constraints constraints(paper_vehicle(), every_limit(), true);
  const SampleTable table(4);
  FlatSamples flat;
  sample_piece(random_piece(3).ends(0), 0.7, table, flat);
  Eigen::MatrixXd before, after;
  evaluate(constraints, flat, before);
  for (int order = 0; order < kGiven; ++order) {
    for (int axis = 0; axis < kAxes; ++axis) {
      FlatSamples moved = flat;
      moved[order].col(axis).array() += 0.1;
      evaluate(constraints, moved, after);
      for (std::size_t r = 0; r < constraints.rows().size(); ++r) {
        bool named = false;
        for (const Entry& entry : constraints.rows()[r].entries) named |= entry.axis == axis && entry.order == order;
        if (!named) CHECK(before.col(static_cast<int>(r)).isApprox(after.col(static_cast<int>(r)), 1e-15));
      }
    }
  }
}

TEST_CASE("at hover each rotor carries a quarter of the weight, whatever the yaw") {
  const Vehicle vehicle = paper_vehicle();
  const Constraints constraints(vehicle, every_limit(), false);
  FlatSamples flat;
  for (auto& derivative : flat) derivative.setZero(4, kAxes);
  flat[0].col(3).setConstant(2.0);
  Eigen::MatrixXd values;
  evaluate(constraints, flat, values);
  CHECK((values.leftCols(4).array() - 0.25 * vehicle.mass * vehicle.gravity).abs().maxCoeff() < 1e-15);
}

}  // namespace halfroll::planner
