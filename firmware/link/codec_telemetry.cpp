// Sending: the messages that show the vehicle, each from the one VehicleStatus.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "link/codec_mavlink.hpp"

namespace halfroll::link {
namespace {

constexpr float kNoNumber = std::numeric_limits<float>::quiet_NaN();
constexpr float kNoseVertical = 0.99619F;  // cos 5 deg

std::uint32_t boot_ms(const VehicleStatus& s) { return static_cast<std::uint32_t>(s.t_us / 1000); }
float altitude_m(const VehicleStatus& s) { return s.origin.alt_m() + s.estimate.p_WB.z(); }
float above_home(const VehicleStatus& s) { return s.estimate.p_WB.z() - (s.home ? s.home->position.z() : 0.F); }
float ground_speed(const VehicleStatus& s) { return s.estimate.v_WB.head<2>().norm(); }

float heading_deg(float yaw_on_wire) {  // 0..360
  const float degrees = yaw_on_wire / kDegree;
  return degrees < 0.F ? degrees + 360.F : degrees;
}

std::uint16_t centidegrees(float degrees) { return static_cast<std::uint16_t>(std::lround(degrees * 100.F) % 36000); }

float nose_up(const Quat& q) { return 2.F * (q.x * q.z - q.w * q.y); }  // z of the nose in W

Vec3 in_body(const Quat& q_WB, const Vec3& v_W) {
  return Eigen::Quaternionf(q_WB.w, q_WB.x, q_WB.y, q_WB.z).conjugate() * v_W;
}

template <class Packed>
void fill_rates(Packed& m, const Vec3& w_B) {
  const Vec3 w = to_wire(w_B);
  m.rollspeed = w.x();
  m.pitchspeed = w.y();
  m.yawspeed = w.z();
}

TxFrame heartbeat(const VehicleStatus& s, Envelope e) {
  mavlink_heartbeat_t m = {};
  m.type = MAV_TYPE_QUADROTOR;
  m.autopilot = s.px4_identity ? MAV_AUTOPILOT_PX4 : MAV_AUTOPILOT_GENERIC;
  m.base_mode = static_cast<std::uint8_t>(29 + (s.armed ? 128 : 0));
  m.custom_mode = wire_mode(s.mode).custom_mode;
  m.system_status = static_cast<std::uint8_t>(s.system_status);
  m.mavlink_version = 3;
  return to_frame(m, e, mavlink_msg_heartbeat_encode_status);
}

std::uint16_t clamped(std::uint32_t count) { return static_cast<std::uint16_t>(std::min<std::uint32_t>(count, 65535)); }

/// Shares of 0.01 %.
std::uint16_t share(std::uint64_t part, std::uint64_t whole) {
  return static_cast<std::uint16_t>(whole == 0 ? 0 : (10000 * part + whole / 2) / whole);
}

TxFrame sys_status(const VehicleStatus& s, Envelope e, int link) {
  constexpr std::uint32_t kGyro = 0x1, kAccel = 0x2, kMag = 0x4, kPressure = 0x8, kGps = 0x20, kRates = 0x400,
                          kAttitude = 0x800, kHeight = 0x2000, kPosition = 0x4000, kMotors = 0x8000,
                          kGeofence = 0x100000, kAhrs = 0x200000, kBattery = 0x2000000, kPrearm = 0x10000000;
  const auto when = [](bool healthy, std::uint32_t bits) { return healthy ? bits : 0U; };
  mavlink_sys_status_t m = {};
  m.onboard_control_sensors_present = kGyro | kAccel | kMag | kPressure | kGps | kRates | kAttitude | kHeight |
                                      kPosition | kMotors | kAhrs | kBattery | kPrearm | when(s.fence_set, kGeofence);
  m.onboard_control_sensors_enabled = m.onboard_control_sensors_present;
  m.onboard_control_sensors_health = when(s.health.rotors, kMotors) | when(s.health.fence, kGeofence) |
                                     when(s.health.gyro, kGyro | kRates) | when(s.health.accelerometer, kAccel) |
                                     when(s.estimate.attitude_valid, kMag | kAttitude | kAhrs) |
                                     when(s.estimate.position_valid, kPressure | kGps | kHeight | kPosition) |
                                     when(s.health.battery, kBattery) | when(s.health.prearm_checks, kPrearm);
  m.voltage_battery = rounded<std::uint16_t>(s.battery_voltage * 1000.F);
  m.current_battery = -1;
  m.battery_remaining = rounded<std::int8_t>(s.state_of_charge * 100.F);
  const LinkTotals none, *known = s.links[static_cast<std::size_t>(link)];
  const LinkTotals& totals = known != nullptr ? *known : none;
  m.drop_rate_comm = share(totals.lost, std::uint64_t{totals.lost} + totals.received);
  m.errors_comm = clamped(totals.bad);
  m.errors_count1 = clamped(totals.refused);
  m.errors_count2 = clamped(s.setpoints_dropped);
  m.errors_count3 = clamped(s.frames_unsent);
  m.errors_count4 = clamped(totals.passed_over);
  return to_frame(m, e, mavlink_msg_sys_status_encode_status);
}

TxFrame extended_sys_state(const VehicleStatus& s, Envelope e) {
  mavlink_extended_sys_state_t m = {};
  m.landed_state = static_cast<std::uint8_t>(s.landed);
  return to_frame(m, e, mavlink_msg_extended_sys_state_encode_status);
}

TxFrame attitude_quaternion(const VehicleStatus& s, Envelope e) {
  mavlink_attitude_quaternion_t m = {};
  const Quat q = to_wire(s.estimate.q_WB);
  m.time_boot_ms = boot_ms(s);
  m.q1 = q.w;
  m.q2 = q.x;
  m.q3 = q.y;
  m.q4 = q.z;
  fill_rates(m, s.estimate.w_WB_B);
  return to_frame(m, e, mavlink_msg_attitude_quaternion_encode_status);
}

TxFrame attitude(const VehicleStatus& s, Envelope e) {
  mavlink_attitude_t m = {};
  const Vec3 angles = wire_angles(s.estimate.q_WB);
  m.time_boot_ms = boot_ms(s);
  m.roll = angles.x();
  m.pitch = angles.y();
  m.yaw = angles.z();
  fill_rates(m, s.estimate.w_WB_B);
  return to_frame(m, e, mavlink_msg_attitude_encode_status);
}

TxFrame local_position(const VehicleStatus& s, Envelope e) {
  mavlink_local_position_ned_t m = {};
  const Vec3 p = to_wire(s.estimate.p_WB), v = to_wire(s.estimate.v_WB);
  m.time_boot_ms = boot_ms(s);
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  m.vx = v.x();
  m.vy = v.y();
  m.vz = v.z();
  return to_frame(m, e, mavlink_msg_local_position_ned_encode_status);
}

TxFrame attitude_target(const VehicleStatus& s, Envelope e) {
  mavlink_attitude_target_t m = {};
  const Quat q = to_wire(s.setpoint.q_WD);
  const Vec3 w = to_wire(s.setpoint.w_WD_D);
  m.time_boot_ms = boot_ms(s);
  m.type_mask = s.setpoint_mask;
  m.q[0] = q.w;
  m.q[1] = q.x;
  m.q[2] = q.y;
  m.q[3] = q.z;
  m.body_roll_rate = w.x();
  m.body_pitch_rate = w.y();
  m.body_yaw_rate = w.z();
  m.thrust = s.thrust_normalised;
  return to_frame(m, e, mavlink_msg_attitude_target_encode_status);
}

TxFrame global_position_int(const VehicleStatus& s, Envelope e) {
  mavlink_global_position_int_t m = {};
  const GlobalPosition place = global_from_local(s.origin, s.estimate.p_WB);
  const Vec3 v = to_wire(s.estimate.v_WB) * 100.F;
  m.time_boot_ms = boot_ms(s);
  m.lat = place.lat_degE7;
  m.lon = place.lon_degE7;
  m.alt = place.alt_mm;
  m.relative_alt = rounded<std::int32_t>(above_home(s) * 1000.F);
  m.vx = rounded<std::int16_t>(v.x());
  m.vy = rounded<std::int16_t>(v.y());
  m.vz = rounded<std::int16_t>(v.z());
  const bool vertical = std::fabs(nose_up(s.estimate.q_WB)) > kNoseVertical;
  m.hdg = vertical ? UINT16_MAX : centidegrees(heading_deg(wire_angles(s.estimate.q_WB).z()));
  return to_frame(m, e, mavlink_msg_global_position_int_encode_status);
}

TxFrame gps_raw_int(const VehicleStatus& s, Envelope e) {
  mavlink_gps_raw_int_t m = {};
  const GlobalPosition place = global_from_local(s.origin, s.estimate.p_WB);
  const Vec3 v = to_wire(s.estimate.v_WB);
  m.time_usec = s.t_us;
  m.fix_type = s.estimate.position_valid ? GPS_FIX_TYPE_3D_FIX : GPS_FIX_TYPE_NO_FIX;
  m.lat = place.lat_degE7;
  m.lon = place.lon_degE7;
  m.alt = place.alt_mm;
  m.alt_ellipsoid = m.alt;
  m.eph = 50;
  m.epv = 50;
  m.vel = rounded<std::uint16_t>(ground_speed(s) * 100.F);
  m.cog = ground_speed(s) < 0.5F ? std::uint16_t{UINT16_MAX} : centidegrees(heading_deg(arctangent2(v.y(), v.x())));
  m.satellites_visible = s.estimate.position_valid ? 12 : 0;
  return to_frame(m, e, mavlink_msg_gps_raw_int_encode_status);
}

TxFrame vfr_hud(const VehicleStatus& s, Envelope e) {
  mavlink_vfr_hud_t m = {};
  m.airspeed = s.estimate.v_WB.norm();
  m.groundspeed = ground_speed(s);
  m.heading = static_cast<std::int16_t>(std::lround(heading_deg(wire_angles(s.estimate.q_WB).z())) % 360);
  m.throttle = rounded<std::uint16_t>(100.F * std::fabs(s.thrust_normalised));
  m.alt = altitude_m(s);
  m.climb = s.estimate.v_WB.z();
  return to_frame(m, e, mavlink_msg_vfr_hud_encode_status);
}

TxFrame battery_status(const VehicleStatus& s, Envelope e) {
  mavlink_battery_status_t m = {};
  m.battery_function = MAV_BATTERY_FUNCTION_ALL;
  m.type = MAV_BATTERY_TYPE_LIPO;
  m.temperature = INT16_MAX;
  std::memset(m.voltages, 0xFF, sizeof m.voltages);  // UINT16_MAX: no such cell
  m.voltages[0] = rounded<std::uint16_t>(s.battery_voltage * 1000.F);
  m.current_battery = -1;
  m.current_consumed = -1;
  m.energy_consumed = -1;
  m.battery_remaining = rounded<std::int8_t>(s.state_of_charge * 100.F);
  m.charge_state = s.health.battery ? MAV_BATTERY_CHARGE_STATE_OK : MAV_BATTERY_CHARGE_STATE_CRITICAL;
  return to_frame(m, e, mavlink_msg_battery_status_encode_status);
}

TxFrame home_position(const VehicleStatus& s, Envelope e) {
  if (!s.home) return {};
  mavlink_home_position_t m = {};
  const Vec3 p = to_wire(s.home->position);
  const Quat q = to_wire(about_z(s.home->yaw));
  m.latitude = s.home->lat_degE7;
  m.longitude = s.home->lon_degE7;
  m.altitude = s.home->alt_mm;
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  m.q[0] = q.w;
  m.q[1] = q.x;
  m.q[2] = q.y;
  m.q[3] = q.z;
  m.approach_x = m.approach_y = m.approach_z = kNoNumber;
  m.time_usec = s.t_us;
  return to_frame(m, e, mavlink_msg_home_position_encode_status);
}

TxFrame gps_global_origin(const VehicleStatus& s, Envelope e) {
  mavlink_gps_global_origin_t m = {};
  m.latitude = s.origin.lat_degE7();
  m.longitude = s.origin.lon_degE7();
  m.altitude = s.origin.alt_mm();
  m.time_usec = s.t_us;
  return to_frame(m, e, mavlink_msg_gps_global_origin_encode_status);
}

TxFrame mission_current(const VehicleStatus& s, Envelope e) {
  mavlink_mission_current_t m = {};
  m.seq = s.mission.current;
  m.total = s.mission.total == 0 ? std::uint16_t{UINT16_MAX} : s.mission.total;
  m.mission_state = static_cast<std::uint8_t>(s.mission.state);
  m.mission_mode = s.mission.in_mission_mode ? 1 : 2;
  m.mission_id = s.mission.id;
  return to_frame(m, e, mavlink_msg_mission_current_encode_status);
}

TxFrame system_time(const VehicleStatus& s, Envelope e) {
  mavlink_system_time_t m = {};
  m.time_unix_usec = s.epoch_at_boot_us == 0 ? 0 : s.epoch_at_boot_us + s.t_us;
  m.time_boot_ms = boot_ms(s);
  return to_frame(m, e, mavlink_msg_system_time_encode_status);
}

TxFrame actuator_output_status(const VehicleStatus& s, Envelope e) {
  mavlink_actuator_output_status_t m = {};
  m.time_usec = s.t_us;
  m.active = static_cast<std::uint32_t>(s.rotor_thrust_normalised.size());
  std::memcpy(m.actuator, s.rotor_thrust_normalised.data(), sizeof s.rotor_thrust_normalised);
  return to_frame(m, e, mavlink_msg_actuator_output_status_encode_status);
}

TxFrame current_mode(const VehicleStatus& s, Envelope e) {
  mavlink_current_mode_t m = {};
  m.standard_mode = wire_mode(s.mode).standard_mode;
  m.custom_mode = wire_mode(s.mode).custom_mode;
  m.intended_custom_mode = wire_mode(s.intended_mode).custom_mode;
  return to_frame(m, e, mavlink_msg_current_mode_encode_status);
}

TxFrame available_modes(int index, Envelope e) {
  if (index < 1 || index > kWireModeCount) return {};
  const WireModeRow& row = kWireModes[index - 1];
  mavlink_available_modes_t m = {};
  m.number_modes = kWireModeCount;
  m.mode_index = static_cast<std::uint8_t>(index);
  m.standard_mode = row.standard_mode;
  m.custom_mode = row.custom_mode;
  m.properties = row.properties;
  std::memcpy(m.mode_name, Text<sizeof m.mode_name>(row.name).c_str(), sizeof m.mode_name);
  return to_frame(m, e, mavlink_msg_available_modes_encode_status);
}

TxFrame autopilot_version(Envelope e) {
  mavlink_autopilot_version_t m = {};
  m.capabilities = MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT | MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT |
                   MAV_PROTOCOL_CAPABILITY_MISSION_INT | MAV_PROTOCOL_CAPABILITY_COMMAND_INT |
                   MAV_PROTOCOL_CAPABILITY_SET_ATTITUDE_TARGET | MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED |
                   MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT | MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION |
                   MAV_PROTOCOL_CAPABILITY_MAVLINK2;
  m.flight_sw_version = 0x02000000;  // 2.0.0, a development build: clients compare anything else with other firmware
  m.uid = 0x68616c6600000000U + e.system;
  return to_frame(m, e, mavlink_msg_autopilot_version_encode_status);
}

TxFrame odometry(const VehicleStatus& s, Envelope e) {
  mavlink_odometry_t m = {};
  const Vec3 p = to_wire(s.estimate.p_WB), v = to_wire(in_body(s.estimate.q_WB, s.estimate.v_WB));
  const Quat q = to_wire(s.estimate.q_WB);
  m.time_usec = s.t_us;
  m.frame_id = MAV_FRAME_LOCAL_NED;
  m.child_frame_id = MAV_FRAME_BODY_FRD;
  m.x = p.x();
  m.y = p.y();
  m.z = p.z();
  m.q[0] = q.w;
  m.q[1] = q.x;
  m.q[2] = q.y;
  m.q[3] = q.z;
  m.vx = v.x();
  m.vy = v.y();
  m.vz = v.z();
  fill_rates(m, s.estimate.w_WB_B);
  m.pose_covariance[0] = m.velocity_covariance[0] = kNoNumber;
  m.estimator_type = MAV_ESTIMATOR_TYPE_AUTOPILOT;
  m.reset_counter = s.estimate.resets;
  return to_frame(m, e, mavlink_msg_odometry_encode_status);
}

TxFrame highres_imu(const VehicleStatus& s, Envelope e) {
  mavlink_highres_imu_t m = {};
  const Vec3 a = to_wire(s.imu.specific_force_B), w = to_wire(s.imu.w_WB_B);
  m.time_usec = s.t_us;
  m.xacc = a.x();
  m.yacc = a.y();
  m.zacc = a.z();
  m.xgyro = w.x();
  m.ygyro = w.y();
  m.zgyro = w.z();
  m.fields_updated = 0x3F;  // accelerometer and gyro
  return to_frame(m, e, mavlink_msg_highres_imu_encode_status);
}

TxFrame altitude(const VehicleStatus& s, Envelope e) {
  mavlink_altitude_t m = {};
  m.time_usec = s.t_us;
  m.altitude_monotonic = m.altitude_local = s.estimate.p_WB.z();
  m.altitude_amsl = altitude_m(s);
  m.altitude_relative = above_home(s);
  m.altitude_terrain = m.bottom_clearance = kNoNumber;
  return to_frame(m, e, mavlink_msg_altitude_encode_status);
}

}  // namespace

TxFrame encode(const Telemetry& in, Envelope envelope) {
  const VehicleStatus& s = in.status;
  switch (in.id) {
    case msg::kHeartbeat: return heartbeat(s, envelope);
    case msg::kSysStatus: return sys_status(s, envelope, in.link);
    case msg::kExtendedSysState: return extended_sys_state(s, envelope);
    case msg::kAttitudeQuaternion: return attitude_quaternion(s, envelope);
    case msg::kAttitude: return attitude(s, envelope);
    case msg::kLocalPosition: return local_position(s, envelope);
    case msg::kAttitudeTarget: return attitude_target(s, envelope);
    case msg::kGlobalPositionInt: return global_position_int(s, envelope);
    case msg::kGpsRawInt: return gps_raw_int(s, envelope);
    case msg::kVfrHud: return vfr_hud(s, envelope);
    case msg::kBatteryStatus: return battery_status(s, envelope);
    case msg::kHomePosition: return home_position(s, envelope);
    case msg::kGpsGlobalOrigin: return gps_global_origin(s, envelope);
    case msg::kMissionCurrent: return mission_current(s, envelope);
    case msg::kSystemTime: return system_time(s, envelope);
    case msg::kActuatorOutputStatus: return actuator_output_status(s, envelope);
    case msg::kCurrentMode: return current_mode(s, envelope);
    case msg::kAvailableModes: return available_modes(in.mode_index, envelope);
    case msg::kAvailableModesMonitor: {
      const mavlink_available_modes_monitor_t m = {};
      return to_frame(m, envelope, mavlink_msg_available_modes_monitor_encode_status);
    }
    case msg::kAutopilotVersion: return autopilot_version(envelope);
    case msg::kOdometry: return odometry(s, envelope);
    case msg::kHighresImu: return highres_imu(s, envelope);
    case msg::kAltitude: return altitude(s, envelope);
    default: return {};
  }
}

}  // namespace halfroll::link
