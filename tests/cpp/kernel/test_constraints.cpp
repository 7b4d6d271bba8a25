#include <doctest/doctest.h>

#include "flights.hpp"
#include "kernel/row_values.hpp"

namespace halfroll::planner {

// Every row's gradient against differences of its value by each flat output: central ones of two widths, whose leading
// error cancels.
TEST_CASE("the gradient of every limited quantity is that of its finite differences") {
  const SampleTable table(8, true);
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Constraints constraints(paper_vehicle(), seed % 2 == 0 ? every_limit() : every_limit_of_motors(), true, 3);
    const Trajectory path = random_piece(seed);
    FlatSamples flat;
    sample_piece(path.ends(0), path.durations[0], table, flat);
    std::vector<Eigen::MatrixXd> slopes;
    differentiate(constraints, corridor(), flat, slopes);
    for (std::size_t r = 0; r < constraints.rows().size(); ++r) {
      const auto& entries = constraints.rows()[r].entries;
      for (std::size_t e = 0; e < entries.size(); ++e) {
        const double step = 2e-4 * (1.0 + std::abs(flat[entries[e].order](0, entries[e].axis)));
        const int row = static_cast<int>(r);
        const auto moved = [&](double by) -> Eigen::ArrayXd {
          FlatSamples other = flat;
          other[entries[e].order].col(entries[e].axis).array() += by;
          Eigen::MatrixXd values;
          evaluate(constraints, corridor(), other, values);
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
  Limits thrusts_and_body_rate;
  thrusts_and_body_rate.rotor_max = 3.0;
  thrusts_and_body_rate.body_rate_max = 20.0;
  for (const Limits& limits : {thrusts_and_body_rate, every_limit()}) {
    const Constraints constraints(paper_vehicle(), limits, false);
    const int rows = static_cast<int>(constraints.rows().size());
    const SampleTable table(4, true);
    Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(4, rows);
    for (int r = 0; r < rows; ++r) {
      if (constraints.rows()[r].entries.size() >= kDynamicEntries) weights.col(r).setConstant(0.3 + 0.2 * r);
    }
    const auto gradient = [&](const FlatSamples& flat, int entry) {
      std::vector<Eigen::MatrixXd> slopes;
      differentiate(constraints, corridor(), flat, slopes);
      double sum = 0.0;
      for (int r = 0; r < rows; ++r) {
        if (weights(0, r) != 0.0 && entry < slopes[r].cols()) sum += weights(0, r) * slopes[r](0, entry);
      }
      return sum;
    };
    for (unsigned seed = 0; seed < 5; ++seed) {
      FlatSamples flat;
      sample_piece(random_piece(seed).ends(0), 0.7, table, flat);
      Eigen::MatrixXd hessians;
      curvature(constraints, flat, weights, hessians);
      const double size = hessians.row(0).cwiseAbs().maxCoeff();
      for (int e = 0; e < constraints.dynamic_entries(); ++e) {
        const auto [axis, order] = dynamic_entry(e);
        const double step = 3e-6 * (1.0 + std::abs(flat[order](0, axis)));
        FlatSamples more = flat, less = flat;
        more[order](0, axis) += step;
        less[order](0, axis) -= step;
        for (int f = 0; f < constraints.dynamic_entries(); ++f) {
          CHECK(std::abs((gradient(more, f) - gradient(less, f)) / (2.0 * step) - hessians(0, dynamic_pair(e, f))) <
                1e-5 * size);
        }
      }
    }
  }
}

TEST_CASE("a quantity that depends on an entry has that entry in its row") {
  const Constraints constraints(paper_vehicle(), every_limit(), true, 3);
  const SampleTable table(4, true);
  FlatSamples flat;
  sample_piece(random_piece(3).ends(0), 0.7, table, flat);
  Eigen::MatrixXd before, after;
  evaluate(constraints, corridor(), flat, before);
  for (int order = 0; order < kSampled; ++order) {
    for (int axis = 0; axis < kAxes; ++axis) {
      FlatSamples moved = flat;
      moved[order].col(axis).array() += 0.1;
      evaluate(constraints, corridor(), moved, after);
      for (std::size_t r = 0; r < constraints.rows().size(); ++r) {
        bool named = false;
        for (const Entry& entry : constraints.rows()[r].entries) named |= entry.axis == axis && entry.order == order;
        if (!named) CHECK(before.col(static_cast<int>(r)).isApprox(after.col(static_cast<int>(r)), 1e-15));
      }
    }
  }
}

// Against differences in time of the thrusts themselves.
TEST_CASE("the rate of a rotor's thrust is the slope of its thrust, and a command or motor speed leads it by its lag") {
  const Vehicle vehicle = paper_vehicle();
  const auto rows_at = [&](const Limits& limits, const Trajectory& path, double tau) {
    const SampleTable ends(4, true);  // 0, 1/3, 2/3, 1
    Trajectory part;
    part.durations = {path.durations[0] * tau};
    part.nodes = {path.nodes[0], path.at(0, tau)};  // ends at tau
    FlatSamples flat;
    Eigen::MatrixXd values;
    sample_piece(part.ends(0), part.durations[0], ends, flat);
    evaluate(Constraints(vehicle, limits, false), {}, flat, values);
    return Eigen::VectorXd(values.row(3));
  };
  Limits thrusts;
  thrusts.rotor_max = 3.0;
  Limits lagging = thrusts, motors = thrusts;
  lagging.rotor_rate_max = 100.0;
  lagging.drive = {0.018, 0.018, false, -3.0, 3.0};
  motors.drive = {0.12, 0.14, true, 0.15, 3.0};
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Trajectory path = random_piece(seed);
    const double tau = 0.6, step = 1e-5;
    const Eigen::Vector4d f = rows_at(thrusts, path, tau).head<4>();
    const Eigen::Vector4d slope =
        (rows_at(thrusts, path, tau + step) - rows_at(thrusts, path, tau - step)).head<4>() / (2.0 * step * 0.7);
    const Eigen::VectorXd with_lag = rows_at(lagging, path, tau), of_motors = rows_at(motors, path, tau);
    for (int i = 0; i < 4; ++i) {
      const double size = 1.0 + slope.cwiseAbs().maxCoeff();
      CHECK(with_lag[4 + 2 * i] == doctest::Approx(slope[i]).epsilon(1e-5).scale(size));
      CHECK(with_lag[5 + 2 * i] == doctest::Approx(f[i] + 0.018 * slope[i]).epsilon(1e-5).scale(size));
      if (f[i] < 0.1) continue;  // a motor never is that slow
      const double speed = std::sqrt(f[i]), speed_slope = slope[i] / (2.0 * speed);
      CHECK(of_motors[4 + 2 * i] ==
            doctest::Approx(speed * (speed + 0.12 * speed_slope - std::sqrt(3.0))).epsilon(1e-5).scale(size));
      CHECK(of_motors[5 + 2 * i] ==
            doctest::Approx(speed * (speed + 0.14 * speed_slope - std::sqrt(0.15))).epsilon(1e-5).scale(size));
    }
  }
}

TEST_CASE("samples of limits that jump at the nodes include both ends of a piece") {
  CHECK(SampleTable(8, true)[0].row(7).isApprox(hermite_row(1.0, 0).transpose()));
  CHECK(SampleTable(8)[0].row(7).isApprox(hermite_row(7.0 / 8.0, 0).transpose()));
}

TEST_CASE("at hover each rotor carries a quarter of the weight, whatever the yaw") {
  const Vehicle vehicle = paper_vehicle();
  const Constraints constraints(vehicle, every_limit(), false);
  FlatSamples flat;
  for (auto& derivative : flat) derivative.setZero(4, kAxes);
  flat[0].col(3).setConstant(2.0);
  Eigen::MatrixXd values;
  evaluate(constraints, corridor(), flat, values);
  CHECK((values.leftCols(4).array() - 0.25 * vehicle.mass * vehicle.gravity).abs().maxCoeff() < 1e-15);
}

}  // namespace halfroll::planner
