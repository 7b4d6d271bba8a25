// The proof that a trajectory stays inside its limits at every time, not only at samples. Why: forces of a polynomial
// path are not polynomial; Taylor models bound them on intervals, which are halved until the bound fits (or the depth
// says that it never will).
#pragma once
#include <Eigen/Core>
#include <vector>

#include "constraints.hpp"
#include "trajectory.hpp"

namespace halfroll::planner {

/// Coefficients of 1, tau, .. tau^9 of x, y, z, yaw on one piece.
using Coefficients = Eigen::Matrix<double, kOrder, kAxes, Eigen::RowMajor>;

struct Certificate {
  bool proven = true;
  std::vector<int> unproven;  // pieces, rising
  int piece = -1;             // of the worst that could not be proven
  int bound = -1;             // which, as in Constraints::bounds
  double excess = 0.0;        // by how much it may be exceeded there, in the quantity's unit
  double relative = 0.0;      // the same by the bound's own scale, which tells what is worst
  int intervals = 0;          // looked at

  void refuse(int k, int exceeded, double by, double relatively) {
    unproven.push_back(k);
    if (proven || relatively > relative) piece = k, bound = exceeded, excess = by, relative = relatively;
    proven = false;
  }
};

Certificate certify(const std::vector<Coefficients>& pieces, const std::vector<double>& durations,
                    const std::vector<PieceLimits>& limits, const Constraints& constraints);

}  // namespace halfroll::planner
