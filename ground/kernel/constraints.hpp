// Limited quantities. Why: what holds at a time is one small list of rows, so a new limit is one more row, and solver,
// repair and proof see nothing but margins. row_values.hpp says what they are at samples.
#pragma once
#include <array>
#include <string>
#include <utility>
#include <vector>

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
  /// The lowest derivative of an axis that any row depends on.
  int lowest_order(int axis) const { return lowest_order_[axis]; }
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
  std::array<int, 4> lowest_order_{2, 2, 2, 0};  // of x, y, z, yaw: thrusts depend on these
};

inline int Constraints::dynamic_entries() const { return limits_rates_ ? kRateEntries : kDynamicEntries; }

Entry dynamic_entry(int index);

}  // namespace halfroll::planner
