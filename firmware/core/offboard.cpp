#include "core/offboard.hpp"

#include <cmath>

namespace halfroll {
namespace {

// type_mask of SET_ATTITUDE_TARGET
constexpr std::uint8_t kIgnoreRates = 7;
constexpr std::uint8_t kUnsupported = 8 | 16 | 32;
constexpr std::uint8_t kIgnoreThrust = 64;
constexpr std::uint8_t kIgnoreAttitude = 128;

constexpr std::int64_t kStampOldestUs = -50000, kStampNewestUs = 20000;
constexpr std::uint64_t kFreshAtEntryUs = 100000;
constexpr float kRateMax = 40.F;  // [rad/s]
constexpr float kThrustMax = 1.001F;

bool rate_used(std::uint8_t mask, int axis) { return (mask & (1 << axis)) == 0; }

std::uint64_t microseconds(float seconds) { return static_cast<std::uint64_t>(seconds * 1e6F); }

bool over(std::uint64_t age_us, float limit_s, float patience) { return age_us > microseconds(limit_s * patience); }

/// A stamp close to vehicle time dates the setpoint; any other is some other clock's, and arrival counts.
std::uint64_t stamped(std::uint32_t stamp_ms, std::uint64_t t_us) {
  const std::int64_t ahead = static_cast<std::int64_t>(stamp_ms) * 1000 - static_cast<std::int64_t>(t_us);
  if (stamp_ms == 0 || ahead < kStampOldestUs || ahead > kStampNewestUs) return t_us;
  return static_cast<std::uint64_t>(stamp_ms) * 1000;
}

}  // namespace

void Offboard::enter(std::uint64_t t_us) {
  entered_us_ = t_us;
  has_owner_ = false;
  if (has_setpoint_ && t_us - last_good_us_ > kFreshAtEntryUs) has_setpoint_ = false;
}

const char* Offboard::judge(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params) const {
  const bool attitude = (in.type_mask & kIgnoreAttitude) == 0;
  if ((in.type_mask & kUnsupported) != 0) return "type mask";
  if ((in.type_mask & kIgnoreThrust) != 0) return "no thrust";
  if (!attitude && (in.type_mask & kIgnoreRates) != 0) return "no attitude, no rates";
  if (!(std::abs(in.thrust) <= kThrustMax)) return "thrust";
  for (int axis = 0; axis < 3; ++axis) {
    if (rate_used(in.type_mask, axis) && !(std::abs(in.w_WD_D[axis]) <= kRateMax)) return "body rate";
  }
  if (attitude) {
    const Quat& q = in.q_WD;
    const float norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    if (!(norm2 >= 0.81F && norm2 <= 1.21F)) return "quaternion";
  }
  const std::uint32_t older_by = last_stamp_ms_ - in.stamp_ms;
  if (has_owner_ && in.source == owner_ && in.stamp_ms != 0 && older_by >= 1 && older_by <= 1000) return "older";
  const bool owner_silent = over(t_us - last_good_us_, params.offboard_loss_after, owner_patience_);
  if (active && has_owner_ && in.source != owner_ && !owner_silent) return "another source";
  return nullptr;
}

const char* Offboard::accept(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params) {
  if (const char* why = judge(in, t_us, active, params)) {
    ++dropped_;
    return why;
  }
  const Quat& q = in.q_WD;
  setpoint_.attitude_used = (in.type_mask & kIgnoreAttitude) == 0;
  if (setpoint_.attitude_used) {
    const float scale = 1.F / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    setpoint_.q_WD = {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
  }
  for (int axis = 0; axis < 3; ++axis) {
    const bool used = rate_used(in.type_mask, axis);
    setpoint_.rate_used[static_cast<std::size_t>(axis)] = used;
    setpoint_.w_WD_D[axis] = used ? in.w_WD_D[axis] : 0.F;
  }
  setpoint_.thrust = in.thrust * params.thrust_reference;
  setpoint_.t_us = stamped(in.stamp_ms, t_us);
  type_mask_ = in.type_mask;
  last_good_us_ = t_us;
  last_stamp_ms_ = in.stamp_ms;
  has_setpoint_ = true;
  has_owner_ = true;
  owner_ = in.source;
  owner_is_ground_ = in.ground_station;
  owner_patience_ = in.patience;
  return nullptr;
}

OffboardStage Offboard::stage(std::uint64_t t_us, bool armed, const Params& params) const {
  if (!has_setpoint_) {
    const bool late = armed && t_us - entered_us_ > microseconds(params.offboard_start_timeout);
    return late ? OffboardStage::kNeverStarted : OffboardStage::kWaiting;
  }
  const std::uint64_t age = t_us - last_good_us_;
  if (!armed || !over(age, params.offboard_rate_after, owner_patience_)) return OffboardStage::kTracking;
  if (!over(age, params.offboard_hold_after, owner_patience_)) return OffboardStage::kNoRates;
  return over(age, params.offboard_loss_after, owner_patience_) ? OffboardStage::kLost : OffboardStage::kRecovering;
}

}  // namespace halfroll
