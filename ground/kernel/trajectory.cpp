#include "trajectory.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numeric>

namespace halfroll::planner {
namespace {

/// i (i-1) .. (i-r+1)
double falling(int i, int r) {
  double product = 1.0;
  for (int j = 0; j < r; ++j) product *= i - j;
  return product;
}

BasisRow monomials(double tau, int r) {
  BasisRow row = BasisRow::Zero();
  double power = 1.0;
  for (int i = r; i < kOrder; ++i, power *= tau) row[i] = falling(i, r) * power;
  return row;
}

Eigen::Matrix<double, kOrder, kOrder> inverted() {
  Eigen::Matrix<double, kOrder, kOrder> ends;
  for (int d = 0; d < kGiven; ++d) {
    ends.row(d) = monomials(0.0, d);
    ends.row(kGiven + d) = monomials(1.0, d);
  }
  return (24.0 * ends.inverse()).array().round() / 24.0;  // its entries are whole numbers over 4!
}

}  // namespace

const Eigen::Matrix<double, kOrder, kOrder>& hermite_matrix() {
  static const Eigen::Matrix<double, kOrder, kOrder> matrix = inverted();
  return matrix;
}

BasisRow hermite_row(double tau, int r) { return hermite_matrix().transpose() * monomials(tau, r); }

double Trajectory::total() const { return std::accumulate(durations.begin(), durations.end(), 0.0); }

Ends Trajectory::ends(int piece) const {
  Ends ends;
  double power = 1.0;
  for (int d = 0; d < kGiven; ++d, power *= durations[piece]) {
    ends.row(d) = power * nodes[piece].row(d);
    ends.row(kGiven + d) = power * nodes[piece + 1].row(d);
  }
  return ends;
}

Node Trajectory::at(int piece, double tau) const {
  const Ends z = ends(piece);
  Node node;
  double power = 1.0;
  for (int d = 0; d < kGiven; ++d, power /= durations[piece]) {
    node.row(d) = power * (hermite_row(tau, d).transpose() * z);
  }
  return node;
}

Trajectory Trajectory::stretched(double factor) const {
  Trajectory slower = *this;
  for (double& duration : slower.durations) duration *= factor;
  for (Node& node : slower.nodes) {
    for (int d = 1; d < kGiven; ++d) node.row(d) *= std::pow(factor, -d);
  }
  return slower;
}

}  // namespace halfroll::planner
