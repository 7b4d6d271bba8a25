// Rows of thrust and attitude. Why: apart from the other rows, because these are what is compiled for each processor.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "constraints.hpp"
#include "samples.hpp"

namespace halfroll::planner {

/// Fills the columns of `values` (count, rows) that belong to them.
void evaluate_dynamics(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values);

/// Fills the slopes of these rows, already of their sizes.
void differentiate_dynamics(const Constraints& constraints, const FlatSamples& flat,
                            std::vector<Eigen::MatrixXd>& slopes);

}  // namespace halfroll::planner
