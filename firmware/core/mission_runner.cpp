#include "core/mission_runner.hpp"

#include <cmath>

#include "core/trig.hpp"

namespace halfroll {
namespace {

constexpr int kItemsPerTick = 16;     // items that need no time; bounds the work of one tick
constexpr float kYawReached = 0.05F;  // [rad]
constexpr float kOverLanding = 0.5F;  // [m], horizontal, before a landing goes down
constexpr float kLandingRest = 0.5F;  // [m/s], horizontal: one that flies past comes back first

}  // namespace

void MissionRunner::reset(int first) {
  *this = MissionRunner{};
  current_ = first;
}

void MissionRunner::set_current(int seq) {
  current_ = seq;
  entered_ = false;
  complete_ = false;
}

void MissionRunner::set_current_and_clear_jumps(int seq) {
  set_current(seq);
  jumps_done_ = {};
}

void MissionRunner::resume() {
  entered_ = false;
  yaw_known_ = false;
}

void MissionRunner::take_over(int seq) {
  if (seq > current_) {
    if (overtaken_ == overtaken_end_) overtaken_ = current_;
    overtaken_end_ = seq;
  }
  set_current(seq);
}

void MissionRunner::reach(int seq) {
  if (reached_count_ < kReachedQueue)
    reached_[static_cast<std::size_t>(reached_count_++)] = static_cast<std::int16_t>(seq);
}

int MissionRunner::take_reached() {
  if (overtaken_ < overtaken_end_) return overtaken_++;
  if (reached_count_ == 0) return -1;
  const int seq = reached_[0];
  for (std::size_t i = 1; i < static_cast<std::size_t>(reached_count_); ++i) reached_[i - 1] = reached_[i];
  --reached_count_;
  return seq;
}

void MissionRunner::go_to(int seq, const MissionItems& items) {
  entered_ = false;
  if (seq < items.count()) {
    current_ = seq;
  } else {
    complete_ = true;  // the current item stays the last one
  }
}

void MissionRunner::enter(const FlightItem& item, const Estimate& estimate, const FlatReference& reference,
                          bool landed) {
  entered_ = true;
  arrived_ = false;
  waited_s_ = 0.F;
  climbing_ = item.kind == ItemKind::kTakeoff || (landed && item.kind == ItemKind::kWaypoint);
  entry_position_ = landed ? estimate.p_WB : reference.position;
  if (!yaw_known_) wanted_yaw_ = reference.yaw;
  if (item.has_yaw) wanted_yaw_ = item.yaw + (item.yaw_relative ? wanted_yaw_ : 0.F);
  yaw_known_ = true;
}

MissionStep MissionRunner::step(const MissionItems& items, const Estimate& estimate, const FlatReference& reference,
                                const Vec3& home, bool landed, float dt, const Params& params) {
  MissionStep out;
  const float cruise = speed_ > 0.F ? std::min(speed_, params.speed_max) : params.cruise_speed;
  out.target = {reference.position, reference.yaw, cruise, params.climb_speed, params.descent_speed};

  for (int n = 0; n < kItemsPerTick; ++n) {
    if (complete_ || items.count() == 0) {
      out.complete = true;
      return out;
    }
    const int seq = current_;
    const FlightItem item = items.item(seq);
    if (!entered_) enter(item, estimate, reference, landed);
    out.target.position = entry_position_;
    out.target.yaw = wanted_yaw_;

    switch (item.kind) {
      case ItemKind::kTakeoff:
      case ItemKind::kWaypoint: {
        if (climbing_) {
          const float height = item.kind == ItemKind::kTakeoff ? item.position.z() : home.z() + params.takeoff_altitude;
          out.target.position.z() = std::max(height, entry_position_.z());
          if (std::abs(out.target.position.z() - estimate.p_WB.z()) > kTakeoffReached) return out;
          climbing_ = false;
          entry_position_ = out.target.position;
        }
        if (item.has_position) out.target.position = item.position;
        const float radius = item.radius > 0.F ? item.radius : params.acceptance_radius;
        arrived_ = arrived_ || (out.target.position - estimate.p_WB).norm() < radius;
        if (arrived_) waited_s_ += dt;
        if (!arrived_ || waited_s_ < item.hold_s) return out;
        break;
      }
      case ItemKind::kLand: {
        if (item.has_position) {
          out.target.position.x() = item.position.x();
          out.target.position.y() = item.position.y();
        }
        const Vec3 off = out.target.position - estimate.p_WB;
        const bool slow = reference.velocity.head<2>().norm() < kLandingRest;
        arrived_ = arrived_ || (slow && off.head<2>().norm() < kOverLanding);
        out.descend = arrived_;
        if (!arrived_ || !landed) return out;
        break;
      }
      case ItemKind::kReturn:
        out.return_home = true;
        reach(seq);
        complete_ = true;
        return out;
      case ItemKind::kDelay:
        waited_s_ += dt;
        if (waited_s_ < item.hold_s) return out;
        break;
      case ItemKind::kYaw:
        if (std::abs(wrapped_angle(wanted_yaw_ - reference.yaw)) > kYawReached) return out;
        break;
      case ItemKind::kJump: {
        std::uint16_t& done = jumps_done_[static_cast<std::size_t>(seq)];
        reach(seq);
        if (item.repeats < 0 || done < item.repeats) {
          if (item.repeats >= 0) ++done;
          go_to(item.jump_to, items);
        } else {
          go_to(seq + 1, items);
        }
        continue;
      }
      case ItemKind::kSpeed:
        if (item.speed != -1.F) speed_ = item.speed;
        break;
      case ItemKind::kSetHome:
        out.set_home = true;
        out.home = item.has_position ? item.position : estimate.p_WB;
        reach(seq);
        go_to(seq + 1, items);
        return out;
      case ItemKind::kSkip: break;
    }
    reach(seq);
    go_to(seq + 1, items);
  }
  return out;
}

}  // namespace halfroll
