#include "link/position_targets.hpp"

#include "core/quaternion.hpp"

namespace halfroll::link {
namespace {

constexpr std::uint16_t kIgnorePosition = 7;

bool is_place_on_earth(const PositionTarget& m) {
  return std::abs(std::int64_t{m.x}) <= 900000000 && std::abs(std::int64_t{m.y}) <= 1800000000;
}

}  // namespace

LinkPositionSetpoint read_position_target(const PositionTarget& m, const PositionDatum& datum) {
  LinkPositionSetpoint out;
  out.type_mask = m.type_mask;
  PositionSetpoint& s = out.setpoint;
  s.position = m.position;
  s.velocity = m.velocity;
  s.acceleration = m.acceleration;
  s.yaw = m.yaw;
  s.yaw_rate = m.yaw_rate;
  const bool uses_position = (m.type_mask & kIgnorePosition) != kIgnorePosition;
  if (m.global) {
    const bool amsl = m.frame == kFrameGlobal || m.frame == kFrameGlobalInt;
    const bool above_home = m.frame == kFrameRelative || m.frame == kFrameRelativeInt;
    out.frame_known = amsl || above_home;
    const float nowhere = std::numeric_limits<float>::quiet_NaN();
    if (!is_place_on_earth(m)) {
      s.position = Vec3::Constant(nowhere);
    } else {
      s.position = local_from_global(datum.origin, {m.x, m.y, datum.origin.alt_mm()});
      s.position.z() = above_home ? datum.home_z + m.alt : m.alt - datum.origin.alt_m();
    }
  } else if (m.frame == kFrameBody) {
    out.frame_known = !uses_position;
    s.velocity = rotate(about_z(datum.heading), m.velocity);
    s.acceleration = rotate(about_z(datum.heading), m.acceleration);
    s.yaw = datum.heading + m.yaw;
  } else {
    out.frame_known = m.frame == kFrameLocalNed;
  }
  return out;
}

}  // namespace halfroll::link
