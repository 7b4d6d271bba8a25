#include "row_values.hpp"

#include <cmath>

#include "dynamic_rows.hpp"

namespace halfroll::planner {
namespace {

/// Value and slopes of the heading's row at a sample.
struct HeadingRow {
  double value, by_x, by_y, by_yaw;
};
HeadingRow heading_row(const Heading& heading, const FlatSamples& flat, int i) {
  const bool path = heading.rule == Heading::Rule::kPath;
  const double sign = path ? 1.0 : -1.0;  // of d by the position or velocity
  const double dx = path ? flat[1](i, 0) : heading.x - flat[0](i, 0);
  const double dy = path ? flat[1](i, 1) : heading.y - flat[0](i, 1);
  const double c = std::cos(flat[0](i, 3)), s = std::sin(flat[0](i, 3));
  const double size = std::sqrt(dx * dx + dy * dy + heading.slack * heading.slack);
  return {c * dx + s * dy - heading.cosine * size, sign * (c - heading.cosine * dx / size),
          sign * (s - heading.cosine * dy / size), c * dy - s * dx};
}

}  // namespace

void evaluate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
              Eigen::MatrixXd& values) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const int count = static_cast<int>(flat[0].rows());
  values.resize(count, static_cast<int>(rows.size()));
  for (int r = 0; r < static_cast<int>(rows.size()); ++r) {
    auto column = values.col(r).array();
    switch (rows[r].quantity) {
      case Quantity::kForceZ: column = v.mass * (flat[2].col(2).array() + v.gravity); break;
      case Quantity::kSpeedSquared: column = flat[1].leftCols<3>().rowwise().squaredNorm(); break;
      case Quantity::kHeight: column = flat[0].col(2).array(); break;
      case Quantity::kHeading:
        for (int i = 0; i < count; ++i) column[i] = heading_row(constraints.limits().heading, flat, i).value;
        break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(rows[r].wall);
        column = wall.x * flat[0].col(0).array() + wall.y * flat[0].col(1).array();
        break;
      }
      default: break;  // of the dynamics, below
    }
  }
  evaluate_dynamics(constraints, flat, values);
}

void differentiate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
                   std::vector<Eigen::MatrixXd>& slopes) {
  const Vehicle& v = constraints.vehicle();
  const auto& rows = constraints.rows();
  const int count = static_cast<int>(flat[0].rows());
  slopes.resize(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    slopes[r].resize(count, static_cast<int>(rows[r].entries.size()));
    switch (rows[r].quantity) {
      case Quantity::kForceZ: slopes[r].setConstant(v.mass); break;
      case Quantity::kSpeedSquared: slopes[r] = 2.0 * flat[1].leftCols<3>(); break;
      case Quantity::kHeight: slopes[r].setOnes(); break;
      case Quantity::kHeading:
        for (int i = 0; i < count; ++i) {
          const HeadingRow row = heading_row(constraints.limits().heading, flat, i);
          slopes[r].row(i) << row.by_x, row.by_y, row.by_yaw;
        }
        break;
      case Quantity::kWall: {
        const Wall wall = piece.wall(rows[r].wall);
        slopes[r].col(0).setConstant(wall.x);
        slopes[r].col(1).setConstant(wall.y);
        break;
      }
      default: break;  // of the dynamics, below
    }
  }
  differentiate_dynamics(constraints, flat, slopes);
}

}  // namespace halfroll::planner
