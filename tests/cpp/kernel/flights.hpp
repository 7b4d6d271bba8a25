// Flights for the tests of the kernel: random but repeatable ones, and rest-to-rest courses.
#pragma once
#include <cmath>
#include <random>

#include "kernel/interior_point.hpp"

namespace halfroll::planner {

inline Vehicle paper_vehicle() { return {0.571, {0.00365, 0.0041, 0.0068}, 0.175, 0.010, 9.81}; }

inline Limits every_limit() {
  Limits limits;
  limits.rotor_min = 0.15;
  limits.rotor_max = 3.0;
  limits.force_min = 0.2;
  limits.force_z_min = 0.5;
  limits.body_rate_max = 20.0;
  limits.floor = 0.0;
  limits.ceiling = 9.0;
  limits.tilt_cos_min = 0.2;
  limits.rotor_rate_max = 100.0;
  limits.drive = {0.018, 0.018, false, 0.0, 3.0};
  limits.heading = {Heading::Rule::kPath, 0.97, 0.3};
  return limits;
}

/// The same with motors whose speed lags.
inline Limits every_limit_of_motors() {
  Limits limits = every_limit();
  limits.drive = {0.12, 0.14, true, 0.15, 3.0};
  limits.heading = {Heading::Rule::kPoint, 0.97, 0.1, 3.0, -2.0};
  return limits;
}

inline PieceLimits corridor() { return {10.0, {{0.6, 0.8, 5.0}, {-1.0, 0.0, 2.0}}}; }

/// One piece with derivatives of the size of real flight.
inline Trajectory random_piece(unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  Trajectory path;
  path.durations = {0.7};
  for (int k = 0; k < 2; ++k) {
    Node node;
    const double size[kGiven] = {1.0, 2.0, 3.0, 15.0, 80.0};
    for (int d = 0; d < kGiven; ++d) {
      for (int a = 0; a < kAxes; ++a) node(d, a) = size[d] * normal(generator) * (a == 3 ? 0.3 : 1.0);
    }
    path.nodes.push_back(node);
  }
  return path;
}

/// Rest at both ends, free between; times by distance, slow enough for any rotor.
inline Problem course(const std::vector<Eigen::Vector3d>& points, double seconds_a_leg) {
  Problem problem;
  for (std::size_t k = 0; k < points.size(); ++k) {
    Node node = Node::Zero();
    node.row(0).head<3>() = points[k];
    Mask given = Mask::Constant(k == 0 || k + 1 == points.size());
    given.row(0).head<3>().setConstant(true);
    problem.start.nodes.push_back(node);
    problem.given.push_back(given);
    if (k > 0) {
      problem.start.durations.push_back(seconds_a_leg);
      problem.leg.push_back(static_cast<int>(k) - 1);
      problem.limits.push_back({});
    }
  }
  return problem;
}

}  // namespace halfroll::planner
