// Flat outputs at samples of a piece. Why: limits are asked for at fixed fractions of a piece, where the basis is a
// table of constants.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "trajectory.hpp"

namespace halfroll::planner {

constexpr int kSampled = 6;  // derivatives 0..5

/// Tables of the basis at tau_i = i/intervals, i = 0..count-1: (count, 10) for each derivative. The right end is the
/// next piece's left one, and left out without rates.
class SampleTable {
 public:
  using Table = Eigen::Matrix<double, Eigen::Dynamic, kOrder>;
  static constexpr int kRow = 12;  // a row padded to full packs

  /// count: a multiple of Pack::kWidth. rates: with the 5th derivative, which jumps at the nodes, and so both ends.
  explicit SampleTable(int count, bool rates = false);
  int count() const { return static_cast<int>(tables_[0].rows()); }
  int intervals() const { return intervals_; }
  int derivatives() const { return derivatives_; }
  const Table& operator[](int derivative) const { return tables_[derivative]; }
  /// The same numbers by rows of kRow.
  const double* rows(int derivative) const { return rows_[derivative].data(); }

 private:
  int intervals_, derivatives_;
  std::array<Table, kSampled> tables_;
  std::array<std::vector<double>, kSampled> rows_;
};

/// Flat outputs of all samples of a piece: derivative by time, (count, 4) each.
using FlatSamples = std::array<Eigen::Matrix<double, Eigen::Dynamic, kAxes>, kSampled>;

void sample_piece(const Ends& ends, double duration, const SampleTable& table, FlatSamples& flat);

}  // namespace halfroll::planner
