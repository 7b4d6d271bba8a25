// Cholesky factorisation of a symmetric matrix whose rows start late (envelope form). Why: the Hessian of a trajectory
// couples neighbours in time only, but the durations of a leg couple with all of it; their rows are long, all others
// short, and a band would pay for the longest. Time and memory are linear in the number of nodes.
#pragma once
#include <Eigen/Core>
#include <vector>

namespace halfroll::planner {

class Skyline {
 public:
  /// first[i] <= i: the first column of row i that may differ from zero.
  explicit Skyline(std::vector<int> first);

  int size() const { return static_cast<int>(first_.size()); }
  void set_zero() { entries_.setZero(); }
  void add(int i, int j, double value) { entries_[offset_[std::max(i, j)] + std::min(i, j)] += value; }
  /// Factorises this + damping I; false if that is not positive definite.
  bool factorise(double damping);
  /// x of (this + damping I) x = b, after factorise.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  std::vector<int> first_;
  std::vector<std::ptrdiff_t> offset_;  // of column 0 of each row in the storage: entry (i, j) is at offset + j
  Eigen::VectorXd entries_, factor_;
};

}  // namespace halfroll::planner
