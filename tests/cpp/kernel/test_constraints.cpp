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

namespace {

/// Of the sum of weighted rows, by all dynamic entries: differences of its gradient.
Eigen::MatrixXd differences(const Constraints& constraints, const FlatSamples& flat, const Eigen::VectorXd& weights) {
  const int entries = constraints.dynamic_entries();
  const auto gradient = [&](const FlatSamples& at) {
    std::vector<Eigen::MatrixXd> slopes;
    differentiate(constraints, corridor(), at, slopes);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(entries);
    for (int r = 0; r < weights.size(); ++r) {
      if (weights[r] != 0.0) sum.head(slopes[r].cols()) += weights[r] * slopes[r].row(0).transpose();
    }
    return sum;
  };
  Eigen::MatrixXd by(entries, entries);
  for (int e = 0; e < entries; ++e) {
    const auto [axis, order] = dynamic_entry(e);
    const double step = 3e-6 * (1.0 + std::abs(flat[order](0, axis)));
    FlatSamples more = flat, less = flat;
    more[order](0, axis) += step;
    less[order](0, axis) -= step;
    by.col(e) = (gradient(more) - gradient(less)) / (2.0 * step);
  }
  return by;
}

Limits thrusts_and_body_rate() {
  Limits limits;
  limits.rotor_max = 3.0;
  limits.body_rate_max = 20.0;
  return limits;
}

FlatSamples random_samples(unsigned seed) {
  FlatSamples flat;
  sample_piece(random_piece(seed).ends(0), 0.7, SampleTable(4, true), flat);
  return flat;
}

void check_curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::VectorXd& weights,
                     const Eigen::MatrixXd& expected) {
  Eigen::MatrixXd hessians;
  curvature(constraints, flat, weights.transpose().replicate(4, 1), hessians);
  for (int e = 0; e < expected.rows(); ++e) {
    for (int f = 0; f < expected.cols(); ++f) {
      CHECK(std::abs(expected(e, f) - hessians(0, dynamic_pair(e, f))) < 1e-5 * hessians.row(0).cwiseAbs().maxCoeff());
    }
  }
}

}  // namespace

TEST_CASE("the curvature of thrusts and body rate is the slope of their gradient") {
  const Constraints constraints(paper_vehicle(), thrusts_and_body_rate(), false);
  const Eigen::VectorXd weights = Eigen::VectorXd::LinSpaced(static_cast<int>(constraints.rows().size()), 0.3, 1.1);
  for (unsigned seed = 0; seed < 5; ++seed) {
    const FlatSamples flat = random_samples(seed);
    check_curvature(constraints, flat, weights, differences(constraints, flat, weights));
  }
}

// f' = sum of df/dq q', so without third derivatives of f its second ones are those of f, of entries one order apart.
TEST_CASE("the curvature of a rate of thrust is that of the thrust, one derivative higher") {
  const Constraints still(paper_vehicle(), thrusts_and_body_rate(), false), all(paper_vehicle(), every_limit(), false);
  const auto above = [&](int e) {
    const auto [axis, order] = dynamic_entry(e);
    for (int f = 0; f < all.dynamic_entries(); ++f) {
      if (dynamic_entry(f).axis == axis && dynamic_entry(f).order == order + 1) return f;
    }
    return -1;
  };
  for (unsigned seed = 0; seed < 5; ++seed) {
    const FlatSamples flat = random_samples(seed);
    for (int r = 0; r < static_cast<int>(all.rows().size()); ++r) {
      if (!all.rows()[r].of_rotor()) continue;
      const RotorTerms& terms = all.rows()[r].terms;
      Eigen::VectorXd rotor = Eigen::VectorXd::Zero(static_cast<int>(still.rows().size()));
      rotor[terms.rotor] = 1.0;
      const Eigen::MatrixXd H = differences(still, flat, rotor);
      Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(all.dynamic_entries(), all.dynamic_entries());
      expected.topLeftCorner(kDynamicEntries, kDynamicEntries) = terms.share * H;
      for (int e = 0; e < kDynamicEntries; ++e) {
        for (int f = 0; f < kDynamicEntries; ++f) {
          expected(above(e), f) += terms.lead * H(e, f);
          expected(f, above(e)) += terms.lead * H(f, e);
        }
      }
      check_curvature(all, flat, Eigen::VectorXd::Unit(static_cast<int>(all.rows().size()), r), expected);
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
