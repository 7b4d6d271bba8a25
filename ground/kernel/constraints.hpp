// Limited quantities at samples of a piece, and their gradients. Why: what holds at a sample is one small list of rows,
// so a new limit is one more row, and solver, repair and check see nothing but margins.
#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "trajectory.hpp"
#include "vehicle.hpp"

namespace halfroll::planner {

/// An entry of the flat outputs: derivative `order` of an axis.
struct Entry {
  int axis, order;
};

enum class Quantity {
  kRotorThrust,
  kRotorRate,
  kRotorCommand,  // that a rotor whose thrust lags needs
  kRotorRise,     // by how much the fastest speed falls short of what a motor needs, in thrust
  kRotorFall,     // the same for the slowest
  kForce,
  kForceZ,
  kUprightness,  // vertical part of the thrust axis
  kRateSquared,
  kSpeedSquared,
  kHeight,
  kHeading,
  kWall  // distance along the normal of one of the piece's walls
};

/// What a row of a rotor is made of: share f + lead f' - sqrt(root f), f its thrust.
struct RotorTerms {
  int rotor = -1;
  double share = 1.0, lead = 0.0, root = 0.0;
};

/// A quantity and the entries it depends on.
struct Row {
  Quantity quantity;
  std::vector<Entry> entries;
  RotorTerms terms = {};
  int wall = -1;  // of the piece
  bool of_rotor() const { return terms.rotor >= 0; }
};

/// In words, and its unit.
std::pair<std::string, const char*> describe(const Row& row);

/// margin = sign (value of the row - limit)/scale, >= 0 where the bound holds.
struct Bound {
  int row;
  double sign, limit, scale;
  double margin(double value) const { return sign * (value - limit) / scale; }
};

constexpr int kDynamicEntries = 12;  // acceleration, jerk, snap (x, y, z each), yaw and its two derivatives
constexpr int kRateEntries = 16;     // and one more derivative of each: what rates of rotor thrusts depend on

/// Which rows and bounds a vehicle and its limits make. The limits of speed and walls belong to the piece.
class Constraints {
 public:
  /// walls: the most that any piece has.
  Constraints(const Vehicle& vehicle, const Limits& limits, bool any_speed_limit, int walls = 0);

  const Vehicle& vehicle() const { return vehicle_; }
  const Limits& limits() const { return limits_; }
  const std::vector<Row>& rows() const { return rows_; }
  const std::vector<Bound>& bounds() const { return bounds_; }
  /// How quickly rotor thrusts change is limited. That depends on the 5th derivative, which jumps at the nodes, so
  /// samples then include both ends of a piece.
  bool limits_rates() const { return limits_rates_; }
  /// How many of the dynamic entries the rows depend on.
  int dynamic_entries() const;
  /// The bound as it is on a piece.
  Bound on_piece(int bound, const PieceLimits& piece) const;

 private:
  void add(Quantity quantity, std::vector<Entry> entries, RotorTerms terms = {});
  void add_rotor_rates(int rotor);
  void bound(double sign, double limit, double scale);

  Vehicle vehicle_;
  Limits limits_;
  std::vector<Row> rows_;
  std::vector<Bound> bounds_;
  bool limits_rates_ = false;
};

inline int Constraints::dynamic_entries() const { return limits_rates_ ? kRateEntries : kDynamicEntries; }

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

/// (count, rows) values of the rows on a piece.
void evaluate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
              Eigen::MatrixXd& values);

Entry dynamic_entry(int index);
/// Place of an unordered pair of dynamic entries.
constexpr int dynamic_pair(int e, int f) { return e >= f ? e * (e + 1) / 2 + f : f * (f + 1) / 2 + e; }

/// Curvature of a weighted sum of the rows that depend on all of the dynamics: rotor thrusts, their rates (without what
/// the root adds) and body rate. weights (count, rows); hessians (count, pairs): a symmetric matrix by the dynamic
/// entries for each sample.
void curvature(const Constraints& constraints, const FlatSamples& flat, const Eigen::MatrixXd& weights,
               Eigen::MatrixXd& hessians);

/// For each row (count, entries of the row): its gradient.
void differentiate(const Constraints& constraints, const PieceLimits& piece, const FlatSamples& flat,
                   std::vector<Eigen::MatrixXd>& slopes);

}  // namespace halfroll::planner
