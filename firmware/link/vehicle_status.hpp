// Everything telemetry shows, in one value. Why: the autopilot fills it once a step and knows no message layout.
#pragma once
#include <array>
#include <optional>

#include "core/modes.hpp"
#include "core/types.hpp"
#include "link/datagram.hpp"
#include "link/frames.hpp"
#include "link/link_totals.hpp"
#include "link/wire_ids.hpp"

namespace halfroll::link {

enum class SystemStatus : std::uint8_t { kBoot = 1, kStandby = 3, kActive = 4, kCritical = 5, kTerminated = 6 };
using halfroll::LandedState;
using halfroll::MissionState;

/// Home in W and as given: the integers go out as they came in.
struct Home {
  Vec3 position = Vec3::Zero();
  float yaw = 0.F;
  std::int32_t lat_degE7 = 0, lon_degE7 = 0, alt_mm = 0;
  auto state() const { return std::tie(position, yaw, lat_degE7, lon_degE7, alt_mm); }
  bool operator==(const Home& o) const { return state() == o.state(); }
};

inline Home home_at(const Origin& origin, const Vec3& position, float yaw) {
  const GlobalPosition here = global_from_local(origin, position);
  return {position, yaw, here.lat_degE7, here.lon_degE7, here.alt_mm};
}

/// At a place on earth, heading north.
inline Home home_given(const Origin& origin, const GlobalPosition& at) {
  const Vec3 position = local_from_global(origin, at);
  return {position, 0.F, at.lat_degE7, at.lon_degE7, at.alt_mm};
}

struct MissionProgress {
  std::uint16_t current = 0;
  std::uint16_t total = 0;  // 0: none stored
  MissionState state = MissionState::kNone;
  bool in_mission_mode = false;
  std::uint32_t id = 0;
  bool operator==(const MissionProgress& o) const {
    return current == o.current && total == o.total && state == o.state && in_mission_mode == o.in_mission_mode &&
           id == o.id;
  }
};

/// Health of what SYS_STATUS reports; what is not listed is as healthy as the estimator.
struct Health {
  bool gyro = true, accelerometer = true, battery = true, rotors = true, fence = true;
  bool prearm_checks = false;
};

struct VehicleStatus {
  std::uint64_t t_us = 0;
  std::uint64_t epoch_at_boot_us = 0;  // unix time when t_us was 0; 0 if unknown
  bool px4_identity = false;

  bool armed = false;
  Mode mode = Mode::kHold;
  Mode intended_mode = Mode::kHold;
  SystemStatus system_status = SystemStatus::kBoot;
  LandedState landed = LandedState::kOnGround;

  Imu imu;
  Estimate estimate;
  Setpoint setpoint;                                  // in use
  std::uint8_t setpoint_mask = 0;                     // type_mask as received
  float thrust_normalised = 0.F;                      // -1..1
  std::array<float, 4> rotor_thrust_normalised = {};  // thrust / thrust_max

  float battery_voltage = 0.F;  // [V]
  float state_of_charge = 1.F;  // 0..1
  Health health;
  std::array<const LinkTotals*, kLinkCount> links = {};  // as long as the status is used
  std::uint32_t setpoints_dropped = 0, frames_unsent = 0;
  bool fence_set = false;  // GF_MAX_*: shown as present and enabled

  Origin origin;
  std::optional<Home> home;
  MissionProgress mission;
};

}  // namespace halfroll::link
