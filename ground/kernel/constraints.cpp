#include "constraints.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll::planner {
namespace {

// A rotor's thrust depends on the first kDynamicEntries, its rate on all.
const std::vector<Entry> kDynamics = {{0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {2, 3},
                                      {0, 4}, {1, 4}, {2, 4}, {3, 0}, {3, 1}, {3, 2}};
const std::vector<Entry> kRateDynamics = {{0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {2, 3}, {0, 4}, {1, 4},
                                          {2, 4}, {3, 0}, {3, 1}, {3, 2}, {0, 5}, {1, 5}, {2, 5}, {3, 3}};

}  // namespace

std::pair<std::string, const char*> describe(const Row& row) {
  const std::string rotor = "rotor " + std::to_string(row.terms.rotor + 1);
  switch (row.quantity) {
    case Quantity::kRotorThrust: return {rotor, "N"};
    case Quantity::kRotorRate: return {"thrust rate of " + rotor, "N/s"};
    case Quantity::kRotorCommand: return {"command of " + rotor, "N"};
    case Quantity::kRotorRise: return {"motor speed-up of " + rotor, "N"};
    case Quantity::kRotorFall: return {"motor slow-down of " + rotor, "N"};
    case Quantity::kForce: return {"thrust", "N"};
    case Quantity::kForceZ: return {"vertical thrust", "N"};
    case Quantity::kUprightness: return {"cosine of tilt", "1"};
    case Quantity::kRateSquared: return {"body rate squared", "rad²/s²"};
    case Quantity::kSpeedSquared: return {"speed squared", "m²/s²"};
    case Quantity::kHeight: return {"height", "m"};
    case Quantity::kHeading: return {"heading", ""};
    case Quantity::kWall: return {"fence", "m"};
  }
  return {"", ""};
}

Constraints::Constraints(const Vehicle& vehicle, const Limits& limits, bool any_speed_limit, int walls)
    : vehicle_(vehicle), limits_(limits) {
  const std::vector<Entry> velocity = {{0, 1}, {1, 1}, {2, 1}}, acceleration = {{0, 2}, {1, 2}, {2, 2}};
  const double weight = vehicle.mass * vehicle.gravity, scale = limits.rotor_max;
  const int rotors = limits.vertical ? 1 : 4;  // straight up and down all four do the same
  for (int i = 0; i < rotors; ++i) {
    add(Quantity::kRotorThrust, limits.vertical ? std::vector<Entry>{{2, 2}} : kDynamics, {i});
    bound(-1.0, limits.rotor_max, scale);
    bound(1.0, limits.rotor_min, scale);
  }
  for (int i = 0; i < rotors; ++i) add_rotor_rates(i);
  if (!limits.vertical && std::isfinite(limits.force_min)) {
    add(Quantity::kForce, acceleration);
    bound(1.0, limits.force_min, 4.0 * scale);
  }
  if (std::isfinite(limits.force_z_min)) {
    add(Quantity::kForceZ, {{2, 2}});
    bound(1.0, limits.force_z_min, weight);
  }
  if (!limits.vertical && std::isfinite(limits.tilt_cos_min)) {
    add(Quantity::kUprightness, acceleration);
    bound(1.0, limits.tilt_cos_min, 1.0);
  }
  if (!limits.vertical && std::isfinite(limits.body_rate_max)) {
    add(Quantity::kRateSquared, kDynamics);
    const double square = limits.body_rate_max * limits.body_rate_max;
    bound(-1.0, square, square);
  }
  if (any_speed_limit) {
    add(Quantity::kSpeedSquared, velocity);
    bound(-1.0, kNoLimit, 1.0);
  }
  if (std::isfinite(limits.floor) || std::isfinite(limits.ceiling)) {
    add(Quantity::kHeight, {{2, 0}});
    if (std::isfinite(limits.floor)) bound(1.0, limits.floor, 1.0);
    if (std::isfinite(limits.ceiling)) bound(-1.0, limits.ceiling, 1.0);
  }
  if (!limits.vertical && limits.heading.rule != Heading::Rule::kNone) {
    const int order = limits.heading.rule == Heading::Rule::kPath ? 1 : 0;
    add(Quantity::kHeading, {{0, order}, {1, order}, {3, 0}});
    bound(1.0, -limits.heading.slack, 10.0 * limits.heading.slack);
  }
  for (int i = 0; i < walls; ++i) {
    add(Quantity::kWall, {{0, 0}, {1, 0}});
    rows_.back().wall = i;
    bound(-1.0, kNoLimit, 1.0);
  }
}

/// A thrust that follows its command c with a lag needs c = f + lag f'. A motor whose speed, the root of its thrust,
/// does, needs the speed sqrt(f) + lag f'/(2 sqrt(f)); times sqrt(f) that is linear in f'.
void Constraints::add_rotor_rates(int rotor) {
  const std::vector<Entry> entries = limits_.vertical ? std::vector<Entry>{{2, 2}, {2, 3}} : kRateDynamics;
  const Drive& drive = limits_.drive;
  const double scale = limits_.rotor_max;
  if (std::isfinite(limits_.rotor_rate_max)) {
    add(Quantity::kRotorRate, entries, {rotor, 0.0, 1.0});
    bound(-1.0, limits_.rotor_rate_max, limits_.rotor_rate_max);
    bound(1.0, -limits_.rotor_rate_max, limits_.rotor_rate_max);
    limits_rates_ = true;
  }
  if (!std::isfinite(drive.command_max)) return;
  limits_rates_ = true;
  if (drive.of_speed) {
    add(Quantity::kRotorRise, entries, {rotor, 1.0, 0.5 * drive.lag_up, drive.command_max});
    bound(-1.0, 0.0, scale);
    add(Quantity::kRotorFall, entries, {rotor, 1.0, 0.5 * drive.lag_down, drive.command_min});
    bound(1.0, 0.0, scale);
  } else {
    add(Quantity::kRotorCommand, entries, {rotor, 1.0, drive.lag_up});
    bound(-1.0, drive.command_max, scale);
    bound(1.0, drive.command_min, scale);
  }
}

void Constraints::add(Quantity quantity, std::vector<Entry> entries, RotorTerms terms) {
  for (const Entry& entry : entries) lowest_order_[entry.axis] = std::min(lowest_order_[entry.axis], entry.order);
  rows_.push_back({quantity, std::move(entries), terms});
}

void Constraints::bound(double sign, double limit, double scale) {
  bounds_.push_back({static_cast<int>(rows_.size()) - 1, sign, limit, scale});
}

Bound Constraints::on_piece(int index, const PieceLimits& piece) const {
  Bound b = bounds_[index];
  if (rows_[b.row].quantity == Quantity::kSpeedSquared) {
    const double fastest = std::isfinite(piece.speed_max) ? piece.speed_max : 1e3;  // no limit: one that is never met
    b.limit = b.scale = fastest * fastest;
  }
  const int wall = rows_[b.row].wall;
  if (wall >= 0) b.limit = piece.wall(wall).offset;
  return b;
}

Entry dynamic_entry(int index) { return kRateDynamics[index]; }

}  // namespace halfroll::planner
