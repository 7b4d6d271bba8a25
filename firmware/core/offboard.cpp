#include "core/offboard.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll {
namespace {

// type_mask of SET_ATTITUDE_TARGET
constexpr std::uint8_t kIgnoreRates = 7;
constexpr std::uint8_t kUnsupported = 8 | 16 | 32;
constexpr std::uint8_t kIgnoreThrust = 64;
constexpr std::uint8_t kIgnoreAttitude = 128;

// type_mask of SET_POSITION_TARGET_*, from the lowest bit: position, velocity, acceleration (x, y, z each), ...
constexpr std::uint16_t kForce = 512, kIgnoreYaw = 1024, kIgnoreYawRate = 2048;
constexpr float kFarthest = 10e3F;       // [m] from the origin, per axis
constexpr float kFastest = 100.F;        // [m/s]
constexpr float kHardest = 100.F;        // [m/s²]
constexpr float kYawRateFastest = 10.F;  // [rad/s]

constexpr std::int64_t kStampOldestUs = -50000, kStampNewestUs = 20000;
constexpr std::uint64_t kFreshAtEntryUs = 100000;
constexpr float kRateMax = 40.F;  // [rad/s]
constexpr float kThrustMax = 1.001F;

bool rate_used(std::uint8_t mask, int axis) { return (mask & (1 << axis)) == 0; }

/// To the millisecond. By 32 bits: a cast from float to 64 is made with doubles where there is no such instruction.
std::uint64_t microseconds(float seconds) { return std::uint64_t{static_cast<std::uint32_t>(seconds * 1e3F)} * 1000; }

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

/// What is wrong with who sends it and when.
const char* Offboard::judge(const SetpointOrigin& from, std::uint64_t t_us, bool active, const Params& params) const {
  const std::uint32_t older_by = last_stamp_ms_ - from.stamp_ms;
  if (has_owner_ && from.source == owner_ && from.stamp_ms != 0 && older_by >= 1 && older_by <= 1000) return "older";
  const bool owner_silent = over(t_us - last_good_us_, params.offboard_loss_after, owner_patience_);
  if (active && has_owner_ && from.source != owner_ && !owner_silent) return "another source";
  return nullptr;
}

namespace {

/// What is wrong with an attitude setpoint itself.
const char* fault(const LinkSetpoint& in) {
  const bool attitude = (in.type_mask & kIgnoreAttitude) == 0;
  if ((in.type_mask & kUnsupported) != 0) return "type mask";
  if ((in.type_mask & kIgnoreThrust) != 0) return "no thrust";
  if (!attitude && (in.type_mask & kIgnoreRates) != 0) return "no attitude, no rates";
  if (!(std::abs(in.thrust) <= kThrustMax)) return "thrust";
  for (int axis = 0; axis < 3; ++axis) {
    if (rate_used(in.type_mask, axis) && !(std::abs(in.w_WD_D[axis]) <= kRateMax)) return "body rate";
  }
  const Quat& q = in.q_WD;
  const float norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return !attitude || (norm2 >= 0.81F && norm2 <= 1.21F) ? nullptr : "quaternion";
}

/// The parts that the mask uses, the rest zero; or what is wrong with them.
const char* read(const LinkPositionSetpoint& in, PositionSetpoint& out) {
  if (!in.frame_known) return "frame";
  if ((in.type_mask & kForce) != 0) return "type mask";
  const auto take = [](float from, float most, float& to) {
    to = from;
    return std::abs(from) <= most;  // false for a NaN
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const auto used_bit = [&](int group) {
      return (in.type_mask >> (3U * static_cast<unsigned>(group) + axis) & 1U) == 0;
    };
    out.position_used[axis] = used_bit(0);
    out.velocity_used[axis] = used_bit(1);
    out.acceleration_used[axis] = used_bit(2);
    if (!used_bit(0) && !used_bit(1) && !used_bit(2)) return "axis without target";
    if (used_bit(0) && !take(in.setpoint.position[i], kFarthest, out.position[i])) return "position";
    if (used_bit(1) && !take(in.setpoint.velocity[i], kFastest, out.velocity[i])) return "velocity";
    if (used_bit(2) && !take(in.setpoint.acceleration[i], kHardest, out.acceleration[i])) return "acceleration";
  }
  out.yaw_used = (in.type_mask & kIgnoreYaw) == 0;
  out.yaw_rate_used = (in.type_mask & kIgnoreYawRate) == 0;
  if (out.yaw_used && !take(in.setpoint.yaw, 7.F, out.yaw)) return "yaw";
  if (out.yaw_rate_used && !take(in.setpoint.yaw_rate, kYawRateFastest, out.yaw_rate)) return "yaw rate";
  return nullptr;
}

}  // namespace

void Offboard::used(const SetpointOrigin& from, std::uint64_t t_us) {
  last_good_us_ = t_us;
  last_stamp_ms_ = from.stamp_ms;
  has_setpoint_ = true;
  has_owner_ = true;
  owner_ = from.source;
  owner_is_ground_ = from.ground_station;
  owner_patience_ = from.patience;
}

const char* Offboard::accept(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params) {
  const char* why = fault(in);
  if (why == nullptr) why = judge(in.origin, t_us, active, params);
  if (why != nullptr) {
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
    const bool used_axis = rate_used(in.type_mask, axis);
    setpoint_.rate_used[static_cast<std::size_t>(axis)] = used_axis;
    setpoint_.w_WD_D[axis] = used_axis ? in.w_WD_D[axis] : 0.F;
  }
  setpoint_.thrust = in.thrust * params.thrust_reference;
  setpoint_.t_us = stamped(in.origin.stamp_ms, t_us);
  type_mask_ = in.type_mask;
  is_position_ = false;
  used(in.origin, t_us);
  return nullptr;
}

const char* Offboard::accept(const LinkPositionSetpoint& in, std::uint64_t t_us, bool active, const Params& params) {
  PositionSetpoint setpoint;
  const char* why = read(in, setpoint);
  if (why == nullptr) why = judge(in.origin, t_us, active, params);
  if (why != nullptr) {
    ++dropped_;
    return why;
  }
  position_ = setpoint;
  position_.t_us = stamped(in.origin.stamp_ms, t_us);
  is_position_ = true;
  used(in.origin, t_us);
  return nullptr;
}

PositionSetpoint Offboard::position_setpoint(std::uint64_t t_us) const {
  const std::int64_t age_us = static_cast<std::int64_t>(t_us) - static_cast<std::int64_t>(position_.t_us);
  const float age = 1e-6F * static_cast<float>(age_us);
  PositionSetpoint now = position_;
  now.position += (position_.velocity + 0.5F * age * position_.acceleration) * age;
  now.velocity += position_.acceleration * age;
  if (now.yaw_rate_used) now.yaw += position_.yaw_rate * age;
  return now;
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
