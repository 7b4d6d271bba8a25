// Cholesky factorisation along time. Why: a piece couples the unknowns of its two nodes and the durations of its own
// and the two neighbouring legs, and nothing else. So one small dense front goes from piece to piece, takes up what it
// finds and eliminates what it leaves behind: time and memory are linear in the number of pieces.
//
// Unknowns: kNode a node, node by node, then one a group of pieces that share one duration (groups rise by 0 or 1).
// A front: those of the left node, of the right node, of three groups: group g at place g mod 3.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "trajectory.hpp"

namespace halfroll::planner {

constexpr int kTimes = 2 * kNode;   // place of the durations in a front
constexpr int kFront = kTimes + 4;  // padded to full packs
constexpr int kFrontUsed = kFront - 1;

/// Upper triangle, by rows.
struct Front {
  alignas(32) double entries[kFront * kFront];
  double& operator()(int i, int j) { return entries[i * kFront + j]; }
  double operator()(int i, int j) const { return entries[i * kFront + j]; }
};

class Chain {
 public:
  explicit Chain(std::vector<int> group);

  int pieces() const { return static_cast<int>(group_.size()); }
  int groups() const { return group_.back() + 1; }
  int size() const { return time(group_.back()) + 1; }
  int node(int k) const { return kNode * k; }
  int time(int group) const { return kNode * (pieces() + 1) + group; }
  static int place(int group) { return kTimes + group % 3; }

  /// What a piece adds to the matrix.
  Front& piece(int k) { return fronts_[k]; }
  /// Factorises the sum over pieces + damping I. Where that is not positive definite the unknowns that a piece leaves
  /// behind are damped more, and no others. False if nothing helps.
  bool factorise(double damping);
  /// x of (matrix + damping) x = b, after factorise.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;

 private:
  struct Row {
    alignas(32) double entries[kFront];  // 0 for what was eliminated before, and for itself
    double inverse;                      // of the diagonal
    int piece, place;
  };
  /// Eliminates what ends with a piece; the front then holds what goes on.
  bool leave(Front& front, int piece, double damping);
  bool eliminate(Front& front, int piece, int place, double damping);
  void load(const Eigen::VectorXd& x, int piece, double* front) const;

  std::vector<int> group_;
  std::vector<Front> fronts_;
  std::vector<double> more_;  // damping of a piece's own, as it was needed last
  std::vector<Row> rows_;     // in the order of elimination
};

}  // namespace halfroll::planner
