// What the samples of one piece add to gradient and Hessian, by its tau-derivatives and the log of its duration. Why:
// this is where the solver's time goes. At each sample the rows and the curvature make one small matrix by the flat
// outputs; only the sum over samples is carried through the basis, with dense products of fixed size.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "row_values.hpp"

namespace halfroll::planner {

/// Symmetric matrix and vectors by the tau-derivatives of each axis (rows as Ends) and the log duration.
struct PieceSystem {
  static constexpr int kRow = SampleTable::kRow;
  alignas(32) double block[kAxes][kAxes][kOrder * kRow];  // [a][b], b <= a: kOrder rows of kRow
  alignas(32) double by_time[kAxes][kRow];
  alignas(32) double gradient[kAxes][kRow];
  alignas(32) double pull[kAxes][kRow];  // first derivative of the part with curvature
  double time_time, time_gradient;

  /// Of the tau-derivatives alone: matrix times x.
  void multiply(const Ends& x, Ends& out) const;
};

class PieceAssembly {
 public:
  PieceAssembly(const Constraints& constraints, const SampleTable& table);

  /// For weights w of rows at samples, (samples, rows) each: matrix sum w_stiff J'J + curvature of sum w_curved value,
  /// gradient sum w_force J. `curved` empty: without curvature.
  void assemble(const FlatSamples& flat, const std::vector<Eigen::MatrixXd>& slopes, double duration,
                const Eigen::MatrixXd& stiff, const Eigen::MatrixXd& force, const Eigen::MatrixXd& curved,
                PieceSystem& out);

 private:
  int pair(int e, int f) const { return e >= f ? e * (e + 1) / 2 + f : f * (f + 1) / 2 + e; }
  void weigh_rows(const std::vector<Eigen::MatrixXd>& slopes, const Eigen::MatrixXd& stiff,
                  const Eigen::MatrixXd& force, const Eigen::MatrixXd& curved);
  void carry_time(const FlatSamples& flat, PieceSystem& out);
  void carry_axes(PieceSystem& out);

  const Constraints& constraints_;
  const SampleTable& table_;
  std::vector<Entry> entries_;          // that some row depends on, axis by axis
  std::vector<std::vector<int>> rows_;  // of each row's entries: which of entries_
  std::vector<int> dynamic_;            // of the dynamic entries; empty: none
  // At samples: matrix (samples, pairs of entries); gradient and pull (samples, entries).
  Eigen::MatrixXd matrix_, gradient_, pull_, hessians_;
  std::vector<double> inner_;
  std::array<double, kSampled> powers_{};  // of 1/duration
};

}  // namespace halfroll::planner
