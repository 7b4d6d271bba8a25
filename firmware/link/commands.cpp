#include "link/commands.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "link/mission_items.hpp"

namespace halfroll::link {
namespace {

constexpr float kHighest = 1e5F;  // [m], fits the wire's millimetres
constexpr CommandResult kDenied = CommandResult::kDenied;
constexpr std::int32_t kNotGiven = std::numeric_limits<std::int32_t>::max();

bool unused(float p) { return p == 0.F || std::isnan(p); }

/// Params first..7 are all 0 or not given.
bool unused_from(const Command& c, std::size_t first) {
  for (std::size_t i = first - 1; i < c.p.size(); ++i) {
    if (!unused(c.p[i])) return false;
  }
  const auto none = [](std::int32_t angle) { return angle == 0 || angle == kNotGiven; };
  return !c.is_int || first > 6 || ((first > 5 || none(c.x)) && none(c.y));
}

/// A whole number in [least, most], or nothing.
std::optional<int> whole(float p, int least, int most) {
  if (!(p >= static_cast<float>(least) && p <= static_cast<float>(most)) || p != std::floor(p)) return std::nullopt;
  return static_cast<int>(p);
}

std::optional<int> whole_or_nan_as_zero(float p, int least, int most) {
  return whole(std::isnan(p) ? 0.F : p, least, most);
}

std::optional<std::uint32_t> message_id(float p) {
  const std::optional<int> id = whole(p, 0, 0xFFFFFF);
  return id ? std::optional<std::uint32_t>(static_cast<std::uint32_t>(*id)) : std::nullopt;
}

std::optional<Mode> mode_with(std::uint32_t custom_mode) {
  for (const WireModeRow& row : kWireModes) {
    if (row.custom_mode == custom_mode) return row.mode;
  }
  return std::nullopt;
}

Wish mode_wish(std::uint32_t custom_mode) {
  const std::optional<Mode> mode = mode_with(custom_mode);
  return mode ? Wish{ModeWish{*mode}} : Wish{kDenied};
}

/// Place of a command, however it was sent.
struct Place {
  bool given = false, valid = true;
  std::int32_t lat_degE7 = 0, lon_degE7 = 0;
};

Place place(const Command& c) {
  Place out;
  if (!c.is_int && std::isnan(c.p[4]) && std::isnan(c.p[5])) return out;
  out.lat_degE7 = c.is_int ? c.x : to_degE7(c.p[4]);  // NaN, too big: not given
  out.lon_degE7 = c.is_int ? c.y : to_degE7(c.p[5]);
  if (c.is_int && out.lat_degE7 == kNotGiven && out.lon_degE7 == kNotGiven) return out;
  out.given = true;
  out.valid = std::abs(std::int64_t{out.lat_degE7}) <= 900000000 && std::abs(std::int64_t{out.lon_degE7}) <= 1800000000;
  return out;
}

/// Height of p7 in W [m]. LONG: above sea level unless `long_above_home`. None: p7 or the frame makes no sense.
std::optional<float> height_W(const Command& c, const CommandSituation& now, bool long_above_home) {
  if (!std::isfinite(c.p[6])) return std::nullopt;
  const bool amsl = c.is_int ? c.frame == kFrameGlobal || c.frame == kFrameGlobalInt : !long_above_home;
  const bool above_home = c.is_int ? c.frame == kFrameRelative || c.frame == kFrameRelativeInt : long_above_home;
  if (amsl) return c.p[6] - now.origin.alt_m();
  if (above_home) return now.home_z + c.p[6];
  return std::nullopt;
}

Wish arm_disarm(const Command& c) {
  constexpr float kForce = 21196.F, kForceArm = 2989.F;
  const std::optional<int> arm = whole(c.p[0], 0, 1);
  const bool forced = c.p[1] == kForce || (c.p[1] == kForceArm && arm == 1);
  if (!arm || !unused_from(c, 3) || !(forced || unused(c.p[1]))) return kDenied;
  return ArmWish{*arm == 1, forced};
}

Wish set_mode(const Command& c) {
  constexpr int kCustomModeEnabled = 1;
  const std::optional<int> base = whole(c.p[0], 0, 255);
  if (!base || (*base & kCustomModeEnabled) == 0 || !unused_from(c, 4)) return kDenied;
  if (c.p[1] >= 65536.F && unused(c.p[2])) {  // a whole custom_mode in one number
    if (!(c.p[1] < 4294967296.F) || c.p[1] != std::floor(c.p[1])) return kDenied;
    return mode_wish(static_cast<std::uint32_t>(c.p[1]));
  }
  const std::optional<int> main = whole(c.p[1], 0, 255), sub = whole_or_nan_as_zero(c.p[2], 0, 255);
  if (!main || !sub) return kDenied;
  return mode_wish(static_cast<std::uint32_t>(*main) << 16U | static_cast<std::uint32_t>(*sub) << 24U);
}

Wish set_standard_mode(const Command& c) {
  if (!unused_from(c, 2)) return kDenied;
  for (const WireModeRow& row : kWireModes) {
    if (row.standard_mode != 0 && c.p[0] == static_cast<float>(row.standard_mode)) return ModeWish{row.mode};
  }
  return CommandResult::kFailed;
}

Wish takeoff(const Command& c, const CommandSituation& now) {
  if (std::isnan(c.p[6])) return TakeoffWish{};
  const std::optional<float> z = height_W(c, now, !now.px4_identity);
  if (!z || !(*z - now.home_z >= 0.5F && *z - now.home_z <= 500.F)) return kDenied;
  return TakeoffWish{*z - now.home_z};
}

Wish mission_start(const Command& c, const CommandSituation& now) {
  if (!unused_from(c, 3)) return kDenied;
  const std::optional<int> item = whole_or_nan_as_zero(c.p[0], 0, 65535);
  if (!item) return kDenied;
  if (now.mission_count == 0) return CommandResult::kTemporarilyRejected;
  if (*item >= now.mission_count) return kDenied;
  return MissionStartWish{*item == 0 ? -1 : *item};
}

Wish set_mission_current(const Command& c, const CommandSituation& now) {
  const std::optional<int> seq = whole(c.p[0], -1, 65535), reset = whole_or_nan_as_zero(c.p[1], 0, 1);
  if (!seq || !reset || !unused_from(c, 3)) return kDenied;
  if (now.mission_count == 0) return CommandResult::kTemporarilyRejected;
  if (*seq >= now.mission_count) return kDenied;
  return MissionCurrentWish{*seq, *reset == 1};
}

Wish reposition(const Command& c, const CommandSituation& now) {
  constexpr float kFarthest = 10000.F;  // [m]
  const std::optional<int> flags = whole_or_nan_as_zero(c.p[1], 0, 0xFFFFFF);
  const bool default_speed = unused(c.p[0]) || c.p[0] == -1.F;
  const Place where = place(c);
  if (!flags || !(default_speed || (c.p[0] > 0.F && std::isfinite(c.p[0])))) return kDenied;
  if (!where.valid || std::isinf(c.p[3]) || std::isinf(c.p[6])) return kDenied;
  RepositionWish out;
  out.change_to_hold = (*flags & 1) != 0;
  if (!default_speed) out.speed = c.p[0];
  if (where.given) {
    out.position = local_from_global(now.origin, {where.lat_degE7, where.lon_degE7, now.origin.alt_mm()});
    out.has_position = true;
    if (!(out.position.head<2>().norm() <= kFarthest)) return kDenied;
  }
  if (!std::isnan(c.p[6])) {
    const std::optional<float> z = height_W(c, now, false);
    if (!z || *z < now.home_z || *z - now.home_z > kFarthest) return kDenied;
    out.position.z() = *z;
    out.has_height = true;
  }
  out.has_yaw = !std::isnan(c.p[3]);
  if (out.has_yaw) out.yaw = -c.p[3];  // clockwise on the wire
  return out;
}

constexpr float kMostTurns_deg = 3600.F;  // beyond which a float is no heading

Wish condition_yaw(const Command& c) {
  const std::optional<int> direction = whole_or_nan_as_zero(c.p[2], -1, 1),
                           relative = whole_or_nan_as_zero(c.p[3], 0, 1);
  if (!(std::abs(c.p[0]) <= kMostTurns_deg) || std::isinf(c.p[1]) || !direction || !relative || !unused_from(c, 5))
    return kDenied;
  YawWish out;
  out.relative = *relative == 1;
  out.direction = *direction;
  out.yaw = yaw_from_wire_deg(out.relative && *direction < 0 ? -c.p[0] : c.p[0]);
  return out;
}

Wish set_home(const Command& c, const CommandSituation& now) {
  const std::optional<int> here = whole(c.p[0], 0, 1);
  if (!here) return kDenied;
  if (*here == 1) return HomeWish{};
  const Place where = place(c);
  const std::optional<float> z = height_W(c, now, false);
  const bool nowhere = where.lat_degE7 == 0 && where.lon_degE7 == 0;
  if (!where.given || !where.valid || nowhere || !z) return kDenied;
  const bool amsl = !c.is_int || c.frame == kFrameGlobal || c.frame == kFrameGlobalInt;
  const float above_datum = amsl ? c.p[6] : *z;
  if (!(std::fabs(above_datum) <= kHighest)) return kDenied;
  const std::int32_t alt_mm = rounded<std::int32_t>(above_datum * 1000.F) + (amsl ? 0 : now.origin.alt_mm());
  return HomeWish{false, where.lat_degE7, where.lon_degE7, alt_mm};
}

Wish origin_wish(std::int32_t lat_degE7, std::int32_t lon_degE7, float alt_mm) {
  const bool valid = std::abs(std::int64_t{lat_degE7}) <= 900000000 &&
                     std::abs(std::int64_t{lon_degE7}) <= 1800000000 && std::fabs(alt_mm) < 1e8F &&
                     !(lat_degE7 == 0 && lon_degE7 == 0);
  if (!valid) return kDenied;
  return OriginWish{lat_degE7, lon_degE7, rounded<std::int32_t>(alt_mm)};
}

Wish change_speed(const Command& c) {
  if (check_item({{c.p[0], c.p[1], c.p[2], c.p[3]}, 0, 0, 0.F, cmd::kChangeSpeed, kFrameMission, 1}, 1, 0.F) !=
          MissionResult::kAccepted ||
      !unused_from(c, 4)) {
    return kDenied;
  }
  const auto kind = c.p[0] < 2.F    ? SpeedWish::Kind::kGround
                    : c.p[0] == 2.F ? SpeedWish::Kind::kClimb
                                    : SpeedWish::Kind::kDescend;
  return SpeedWish{kind, c.p[1]};
}

Wish flip(const Command& c) {
  if (check_item({{c.p[0], c.p[1], c.p[2], c.p[3]}, 0, 0, 0.F, cmd::kFlip, kFrameMission, 1}, 1, 0.F) !=
          MissionResult::kAccepted ||
      !unused_from(c, 5)) {
    return kDenied;
  }
  FlipWish out;
  out.axis = static_cast<int>(c.p[0]);
  out.turns = c.p[1];
  if (!std::isnan(c.p[2])) out.least_height = c.p[2];
  if (!std::isnan(c.p[3])) out.longest_time = c.p[3];
  return out;
}

/// A command whose first param picks one of a few wishes and whose others may be anything finite.
template <class W, std::size_t N>
Wish choice(float p, const std::pair<int, typename W::Kind> (&kinds)[N]) {
  for (const auto& [number, kind] : kinds) {
    if (p == static_cast<float>(number)) return W{kind};
  }
  return kDenied;
}

}  // namespace

Wish read_command(const Command& c, const CommandSituation& now) {
  switch (c.command) {
    case cmd::kArmDisarm: return arm_disarm(c);
    case cmd::kSetMode: return set_mode(c);
    case cmd::kSetStandardMode: return set_standard_mode(c);
    case cmd::kTakeoff: return takeoff(c, now);
    case cmd::kLand: return LandWish{};
    case cmd::kReturnToLaunch: return unused_from(c, 1) ? Wish{ReturnWish{}} : Wish{kDenied};
    case cmd::kMissionStart: return mission_start(c, now);
    case cmd::kPauseContinue:
      if (!unused_from(c, 2)) return kDenied;
      if (c.p[0] == 0.F) return PauseWish{};
      return c.p[0] == 1.F ? Wish{ContinueWish{}} : Wish{kDenied};
    case cmd::kSetMissionCurrent: return set_mission_current(c, now);
    case cmd::kReposition: return reposition(c, now);
    case cmd::kChangeSpeed: return change_speed(c);
    case cmd::kConditionYaw: return condition_yaw(c);
    case cmd::kSetHome: return set_home(c, now);
    case cmd::kSetGlobalOrigin: {
      const Place where = place(c);
      if (!where.given || !where.valid || !unused_from(Command{0, {c.p[0], c.p[1], c.p[2], c.p[3]}}, 1)) return kDenied;
      return origin_wish(where.lat_degE7, where.lon_degE7, c.p[6] * 1000.F);
    }
    case cmd::kSetMessageInterval: {
      const auto id = message_id(c.p[0]);
      return id && std::isfinite(c.p[1]) ? Wish{IntervalWish{*id, c.p[1]}} : Wish{kDenied};
    }
    case cmd::kGetMessageInterval: {
      const auto id = message_id(c.p[0]);
      return id ? Wish{IntervalQuery{*id}} : Wish{kDenied};
    }
    case cmd::kRequestMessage: {
      const auto id = message_id(c.p[0]);
      return id ? Wish{MessageWish{*id, std::isnan(c.p[1]) ? 0.F : c.p[1], false}} : Wish{kDenied};
    }
    case cmd::kRequestCapabilities: return MessageWish{msg::kAutopilotVersion, 0.F, true};
    case cmd::kGetHomePosition: return MessageWish{msg::kHomePosition, 0.F, true};
    case cmd::kReboot: {
      using Kind = PowerWish::Kind;
      return choice<PowerWish>(c.p[0], {{0, Kind::kNothing}, {1, Kind::kReboot}, {2, Kind::kShutDown}});
    }
    case cmd::kPreflightStorage: {
      using Kind = ParamStorageWish::Kind;
      return choice<ParamStorageWish>(c.p[0],
                                      {{0, Kind::kReload}, {1, Kind::kSave}, {2, Kind::kReset}, {-1, Kind::kNothing}});
    }
    case cmd::kCalibration: return CalibrationWish{};
    case cmd::kRunPrearmChecks: return unused_from(c, 1) ? Wish{PrearmChecksWish{}} : Wish{kDenied};
    case cmd::kFlightTermination: {
      const bool known = c.p[0] == 0.F || (c.p[0] >= 0.5F && c.p[0] <= 1.F);
      return known && unused_from(c, 2) ? Wish{TerminationWish{c.p[0] >= 0.5F}} : Wish{kDenied};
    }
    case cmd::kInvertedFlight: {
      const std::optional<int> inverted = whole(c.p[0], 0, 1);
      return inverted && unused_from(c, 2) ? Wish{InvertedWish{*inverted == 1}} : Wish{kDenied};
    }
    case cmd::kFlip: return flip(c);
    case cmd::kWaypoint:
    case cmd::kLoiterUnlimited:
    case cmd::kLoiterTime:
    case cmd::kSplineWaypoint:
    case cmd::kDelay:
    case cmd::kConditionDelay:
    case cmd::kJump:
    case cmd::kAttitudeWaypoint: return kDenied;  // only in missions
    default: return CommandResult::kUnsupported;
  }
}

Wish read_set_mode(const SetMode& message) {
  constexpr unsigned kCustomModeEnabled = 1;
  return (message.base_mode & kCustomModeEnabled) != 0 ? mode_wish(message.custom_mode) : Wish{kDenied};
}

Wish read_set_origin(const SetGlobalOrigin& message) { return origin_wish(message.lat, message.lon, message.alt_mm); }

}  // namespace halfroll::link
