// Values of the rows at samples of a piece, and their derivatives by the flat outputs. Why: here a row of Constraints
// becomes numbers; rows of the path itself (row_values.cpp) are simple, those of thrust and attitude (dynamic_rows.cpp,
// curvature.cpp) take nearly all of the solver's time.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "constraints.hpp"
#include "samples.hpp"

namespace halfroll::planner {

/// (count, rows) values of the rows on a piece.
void evaluate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
              Eigen::MatrixXd& values);

/// For each row (count, entries of the row): its gradient.
void differentiate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
                   std::vector<Eigen::MatrixXd>& slopes);

/// Place of an unordered pair of dynamic entries.
constexpr int dynamic_pair(int e, int f) { return e >= f ? e * (e + 1) / 2 + f : f * (f + 1) / 2 + e; }

/// Curvature of a weighted sum of the rows that depend on all of the dynamics: rotor thrusts, their rates (without what
/// the root adds, and without third derivatives of the thrusts) and body rate. weights (count, rows); hessians (count,
/// pairs): a symmetric matrix by the dynamic entries for each sample.
void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
               Eigen::MatrixXd& hessians);

}  // namespace halfroll::planner
