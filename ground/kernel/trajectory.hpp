// Pieces of 9th order in Hermite form. Why: with derivatives 0..4 at the nodes as unknowns, positions are met and C4
// holds by construction, every piece depends on its own two nodes only, and no system has to be solved.
//
// p(tau) = sum over ends e = 0, 1 and d = 0..4 of H_ed(tau) T^d y_ed,  tau = (t - t_k)/T in [0, 1];
// H_ed has derivative i at tau = e equal to 1 for i = d and 0 for the other i = 0..4, and zero ones at the other end.
#pragma once
#include <Eigen/Core>
#include <vector>

namespace halfroll::planner {

constexpr int kOrder = 10;  // coefficients of a piece
constexpr int kGiven = 5;   // derivatives 0..4 of a node
constexpr int kAxes = 4;    // x, y, z, yaw
constexpr int kNode = kGiven * kAxes;

using Node = Eigen::Matrix<double, kGiven, kAxes>;  // derivatives by axes, SI
using Ends = Eigen::Matrix<double, kOrder, kAxes>;  // tau-derivatives 0..4 at the start of a piece, then at its end
using BasisRow = Eigen::Matrix<double, kOrder, 1>;

/// Coefficients of 1, tau, .. tau^9 from the Ends of one axis.
const Eigen::Matrix<double, kOrder, kOrder>& hermite_matrix();

/// The row h with h . Ends = derivative r by tau of the piece at tau.
BasisRow hermite_row(double tau, int r);

struct Trajectory {
  std::vector<Node> nodes;        // N + 1
  std::vector<double> durations;  // N [s]

  int pieces() const { return static_cast<int>(durations.size()); }
  double total() const;
  Ends ends(int piece) const;
  /// Derivatives 0..4 at tau of a piece.
  Node at(int piece, double tau) const;
  /// The same path with every time multiplied by `factor`.
  Trajectory stretched(double factor) const;
};

}  // namespace halfroll::planner
