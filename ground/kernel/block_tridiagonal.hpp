// Block-tridiagonal systems, solved in one pass down and one up. Why: the closed form couples each node to its two
// neighbours only, but its rows may have to change places across nodes (a node with position and acceleration given has
// a singular block of its own), so plain block elimination is not safe. Here the rows of two nodes compete for each
// pivot, in a window of fixed size that stays in the first-level cache.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pack.hpp"

namespace halfroll::planner {

/// B unknowns and B equations a node, R right-hand sides at once.
template <int B, int R>
class BlockTridiagonal {
 public:
  static constexpr int kWidth = (3 * B + R + Pack::kWidth - 1) / Pack::kWidth * Pack::kWidth;
  /// Equations of a node against the unknowns of the node before, its own and the one after, then right-hand sides
  /// from column 3 B on.
  using Rows = Eigen::Matrix<double, B, kWidth, Eigen::RowMajor>;
  using Unknowns = Eigen::Matrix<double, B, R, Eigen::RowMajor>;

  explicit BlockTridiagonal(int nodes) : eliminated_(kept()) {
    eliminated_.clear();
    eliminated_.reserve(nodes);
  }

  /// The equations of the next node; what they say of nodes that do not exist must be zero. No entry should
  /// be much larger than 1. False if singular.
  bool push(const Rows& rows) {
    window_.template bottomRows<B>() = rows;
    if (first_) {
      first_ = false;
    } else {
      if (!eliminate(2 * B)) return false;
      eliminated_.push_back(window_.template topRows<B>());
    }
    // what is left knows only the unknowns of this node and of the next one: one block to the left
    for (int i = 0; i < B; ++i) {
      window_.template block<1, 2 * B>(i, 0) = window_.template block<1, 2 * B>(B + i, B);
      window_.template block<1, B>(i, 2 * B).setZero();
      window_.template block<1, R>(i, 3 * B) = window_.template block<1, R>(B + i, 3 * B);
    }
    return true;
  }

  /// After the last node: the unknowns of all nodes by `take(node, unknowns)`, last one first. False if singular.
  template <class Take>
  bool solve(Take take) {
    if (!eliminate(B)) return false;
    eliminated_.push_back(window_.template topRows<B>());
    Unknowns next = Unknowns::Zero(), after = Unknowns::Zero();
    for (int k = static_cast<int>(eliminated_.size()) - 1; k >= 0; --k) {
      const Rows& u = eliminated_[k];
      Unknowns x = u.template middleCols<R>(3 * B);
      x.noalias() -= u.template middleCols<B>(B) * next;
      x.noalias() -= u.template middleCols<B>(2 * B) * after;
      for (int i = B - 1; i >= 0; --i) {
        for (int j = i + 1; j < B; ++j) x.row(i) -= u(i, j) * x.row(j);
        x.row(i) *= u(i, i);  // stored inverted
      }
      take(k, x);
      after = next;
      next = x;
    }
    return true;
  }

  std::size_t bytes() const { return eliminated_.size() * sizeof(Rows); }

 private:
  static constexpr double kSingular = 1e-10;  // where no entry is much larger than 1

  /// The first B unknowns of the window from its first `rows` rows; the diagonal is left inverted.
  bool eliminate(int rows) {
    for (int j = 0; j < B; ++j) {
      int pivot = j;
      for (int i = j + 1; i < rows; ++i) {
        if (std::abs(window_(i, j)) > std::abs(window_(pivot, j))) pivot = i;
      }
      if (!(std::abs(window_(pivot, j)) > kSingular)) return false;
      if (pivot != j) window_.row(j).swap(window_.row(pivot));
      const double inverse = window_(j, j) = 1.0 / window_(j, j);
      const double* from = &window_(j, 0);
      for (int i = j + 1; i < rows; ++i) {
        const Pack factor = splat(-window_(i, j) * inverse);
        double* to = &window_(i, 0);
        for (int c = 0; c < kWidth; c += Pack::kWidth) store(to + c, load(to + c) + factor * load(from + c));
      }
    }
    return true;
  }

  /// Memory stays between solves: to get new pages from the system would take as long as the elimination.
  static std::vector<Rows>& kept() {
    static thread_local std::vector<Rows> rows;
    return rows;
  }

  bool first_ = true;
  Eigen::Matrix<double, 2 * B, kWidth, Eigen::RowMajor> window_;
  std::vector<Rows>& eliminated_;
};

}  // namespace halfroll::planner
