// Limited quantities at samples of a piece, and their gradients. Why: what holds at a sample is one small list of rows,
// so a new limit is one more row, and solver, repair and check see nothing but margins.
#pragma once
#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "trajectory.hpp"
#include "vehicle.hpp"

namespace halfroll::planner {

/// An entry of the flat outputs: derivative `order` of an axis.
struct Entry {
  int axis, order;
};

enum class Quantity { kRotor1, kRotor2, kRotor3, kRotor4, kForce, kForceZ, kRateSquared, kSpeedSquared, kHeight };

/// In words, and its unit.
std::pair<const char*, const char*> describe(Quantity quantity);

/// A quantity and the entries it depends on.
struct Row {
  Quantity quantity;
  std::vector<Entry> entries;
};

/// margin = sign (value of the row - limit)/scale, >= 0 where the bound holds.
struct Bound {
  int row;
  double sign, limit, scale;
  double margin(double value) const { return sign * (value - limit) / scale; }
};

/// Which rows and bounds a vehicle and its limits make. The limit of the speed bound belongs to the piece.
class Constraints {
 public:
  Constraints(const Vehicle& vehicle, const Limits& limits, bool any_speed_limit);

  const Vehicle& vehicle() const { return vehicle_; }
  const Limits& limits() const { return limits_; }
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<Bound>& bounds() const { return bounds_; }
  /// The bound as it is on a piece with this speed limit [m/s], infinite for none.
  Bound on_piece(int bound, double speed_max) const;

 private:
  void add(Quantity quantity, std::vector<Entry> entries);
  void bound(double sign, double limit, double scale);

  Vehicle vehicle_;
  Limits limits_;
  std::vector<Row> rows_;
  std::vector<Bound> bounds_;
};

/// Tables of the basis at tau_i = i/count, i = 0..count-1: (count, 10) for each derivative 0..4.
class SampleTable {
 public:
  using Table = Eigen::Matrix<double, Eigen::Dynamic, kOrder>;
  static constexpr int kRow = 12;  // a row padded to full packs

  explicit SampleTable(int count);  // a multiple of Pack::kWidth
  int count() const { return static_cast<int>(tables_[0].rows()); }
  const Table& operator[](int derivative) const { return tables_[derivative]; }
  /// The same numbers by rows of kRow.
  const double* rows(int derivative) const { return rows_[derivative].data(); }

 private:
  std::array<Table, kGiven> tables_;
  std::array<std::vector<double>, kGiven> rows_;
};

/// Flat outputs of all samples of a piece: derivative by time, (count, 4) each.
using FlatSamples = std::array<Eigen::Matrix<double, Eigen::Dynamic, kAxes>, kGiven>;

void sample_piece(const Ends& ends, double duration, const SampleTable& table, FlatSamples& flat);

/// (count, rows) values of the rows.
void evaluate(const Constraints& constraints, const FlatSamples& flat, Eigen::MatrixXd& values);

constexpr int kDynamicEntries = 12;  // acceleration, jerk, snap (x, y, z each), yaw and its two derivatives
constexpr int kDynamicPairs = kDynamicEntries * (kDynamicEntries + 1) / 2;
Entry dynamic_entry(int index);
/// Place of an unordered pair of dynamic entries.
constexpr int dynamic_pair(int e, int f) { return e >= f ? e * (e + 1) / 2 + f : f * (f + 1) / 2 + e; }

/// Curvature of a weighted sum of the rows that depend on all of the dynamics: rotor thrusts and body rate.
/// weights (count, rows); hessians (count, pairs): a symmetric matrix by the dynamic entries for each sample.
void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
               Eigen::MatrixXd& hessians);

/// For each row (count, entries of the row): its gradient.
void differentiate(const Constraints& constraints, const FlatSamples& flat, std::vector<Eigen::MatrixXd>& slopes);

}  // namespace halfroll::planner
