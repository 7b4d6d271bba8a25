// What a client reads off each message, as facts about the vehicle.
#include <cmath>
#include <string>

#include "client.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

template <class Packed>
Packed shown(std::uint32_t id, const VehicleStatus& status, void (*decode)(const mavlink_message_t*, Packed*)) {
  return client::read(encode(Telemetry{id, status}, Envelope{1, 0}), decode);
}

VehicleStatus flying() {
  VehicleStatus s;
  s.t_us = 12345678;
  s.armed = true;
  s.mode = Mode::kOffboard;
  s.system_status = SystemStatus::kActive;
  s.estimate.p_WB = {10, 20, 30};
  s.estimate.v_WB = {1, 2, 3};
  s.estimate.w_WB_B = {0.1F, 0.2F, 0.3F};
  s.estimate.attitude_valid = s.estimate.position_valid = true;
  s.origin = {473977420, 85455940, 488000};
  s.home = Home{{0, 0, 5}, 0.F, 473977420, 85455940, 493000};
  s.thrust_normalised = -0.4F;
  s.rotor_thrust_normalised = {0.1F, -0.2F, 0.3F, -1.F};
  s.battery_voltage = 16.2F;
  s.state_of_charge = 0.55F;
  return s;
}

}  // namespace

TEST_CASE("heartbeat shows identity, arming and mode as clients read them") {
  VehicleStatus s = flying();
  auto m = shown(msg::kHeartbeat, s, mavlink_msg_heartbeat_decode);
  CHECK(+m.type == 2);
  CHECK(+m.autopilot == 0);
  CHECK(+m.base_mode == 157);
  CHECK(+m.custom_mode == 393216);
  CHECK(+m.system_status == 4);
  CHECK(+m.mavlink_version == 3);
  s.armed = false;
  s.px4_identity = true;
  m = shown(msg::kHeartbeat, s, mavlink_msg_heartbeat_decode);
  CHECK(+m.base_mode == 29);
  CHECK(+m.autopilot == 12);
}

TEST_CASE("flying north, west and up is north, minus east and minus down") {
  const VehicleStatus s = flying();
  const auto local = shown(msg::kLocalPosition, s, mavlink_msg_local_position_ned_decode);
  CHECK(+local.time_boot_ms == 12345);
  CHECK(+local.x == 10.F);
  CHECK(+local.y == -20.F);
  CHECK(+local.z == -30.F);
  CHECK(+local.vx == 1.F);
  CHECK(+local.vy == -2.F);
  CHECK(+local.vz == -3.F);
  const auto global = shown(msg::kGlobalPositionInt, s, mavlink_msg_global_position_int_decode);
  CHECK(+global.lat > 473977420);
  CHECK(+global.lon < 85455940);
  CHECK(+global.alt == 518000);
  CHECK(+global.relative_alt == 25000);
  CHECK(+global.vx == 100);
  CHECK(+global.vz == -300);
  CHECK(+global.hdg == 0);
}

TEST_CASE("a known rate keeps its sign rules in every message") {
  const VehicleStatus s = flying();
  const auto q = shown(msg::kAttitudeQuaternion, s, mavlink_msg_attitude_quaternion_decode);
  CHECK(+q.rollspeed == 0.1F);
  CHECK(+q.pitchspeed == -0.2F);
  CHECK(+q.yawspeed == -0.3F);
  CHECK(+q.q1 == 1.F);
  CHECK(+shown(msg::kAttitude, s, mavlink_msg_attitude_decode).pitchspeed == -0.2F);
}

TEST_CASE("an accelerometer at rest shows minus g down on the wire") {
  VehicleStatus s = flying();
  s.imu.specific_force_B = {0, 0, 9.81F};
  CHECK(+shown(msg::kHighresImu, s, mavlink_msg_highres_imu_decode).zacc == -9.81F);
}

TEST_CASE("the heading is that of the nose, and unknown when the nose points up") {
  VehicleStatus s = flying();
  const float half = std::sqrt(0.5F);
  s.estimate.q_WB = {half, 0, 0, -half};  // nose to the east
  CHECK(+shown(msg::kGlobalPositionInt, s, mavlink_msg_global_position_int_decode).hdg == 9000);
  CHECK(+shown(msg::kVfrHud, s, mavlink_msg_vfr_hud_decode).heading == 90);
  s.estimate.q_WB = {half, 0, -half, 0};  // nose up
  CHECK(+shown(msg::kGlobalPositionInt, s, mavlink_msg_global_position_int_decode).hdg == UINT16_MAX);
}

TEST_CASE("thrust keeps its sign where the message has one") {
  VehicleStatus s = flying();
  s.setpoint_mask = 128;
  s.setpoint.w_WD_D = {1, 2, 3};
  const auto target = shown(msg::kAttitudeTarget, s, mavlink_msg_attitude_target_decode);
  CHECK(+target.thrust == -0.4F);
  CHECK(+target.type_mask == 128);
  CHECK(+target.body_yaw_rate == -3.F);
  CHECK(+shown(msg::kVfrHud, s, mavlink_msg_vfr_hud_decode).throttle == 40);
  const auto rotors = shown(msg::kActuatorOutputStatus, s, mavlink_msg_actuator_output_status_decode);
  CHECK(+rotors.active == 4);
  CHECK(+rotors.actuator[3] == -1.F);
}

TEST_CASE("sensors: what MAVSDK needs is present, the geofence only healthy") {
  VehicleStatus s = flying();
  s.health.prearm_checks = true;
  auto m = shown(msg::kSysStatus, s, mavlink_msg_sys_status_decode);
  CHECK(+m.onboard_control_sensors_present == 0x1220EC2FU);
  CHECK(+m.onboard_control_sensors_enabled == +m.onboard_control_sensors_present);
  CHECK(+m.onboard_control_sensors_health == (m.onboard_control_sensors_present | 0x100000U));
  CHECK(+m.voltage_battery == 16200);
  CHECK(+m.battery_remaining == 55);
  s.estimate.position_valid = s.health.prearm_checks = false;
  m = shown(msg::kSysStatus, s, mavlink_msg_sys_status_decode);
  CHECK((m.onboard_control_sensors_health & 0x20U) == 0);
  CHECK((m.onboard_control_sensors_health & 0x10000000U) == 0);
  CHECK((m.onboard_control_sensors_health & 0x1U) != 0);
}

TEST_CASE("home and origin repeat their integers") {
  VehicleStatus s = flying();
  const auto home = shown(msg::kHomePosition, s, mavlink_msg_home_position_decode);
  CHECK(+home.latitude == 473977420);
  CHECK(+home.altitude == 493000);
  CHECK(+home.z == -5.F);
  CHECK(std::isnan(home.approach_x));
  CHECK(+home.q[0] == 1.F);
  s.origin = {473977420, 85455940, 123456};
  CHECK(+shown(msg::kGpsGlobalOrigin, s, mavlink_msg_gps_global_origin_decode).altitude == 123456);
  s.home.reset();
  CHECK(encode(Telemetry{msg::kHomePosition, s}, Envelope{}).size == 0);
}

TEST_CASE("no mission has no total, a mission has its id") {
  VehicleStatus s = flying();
  CHECK(+shown(msg::kMissionCurrent, s, mavlink_msg_mission_current_decode).total == UINT16_MAX);
  s.mission = {3, 7, MissionState::kActive, true, 0xABCD1234U};
  const auto m = shown(msg::kMissionCurrent, s, mavlink_msg_mission_current_decode);
  CHECK(+m.seq == 3);
  CHECK(+m.total == 7);
  CHECK(+m.mission_state == 3);
  CHECK(+m.mission_mode == 1);
  CHECK(+m.mission_id == 0xABCD1234U);
  CHECK(+m.fence_id == 0);
}

TEST_CASE("modes are listed as the contract numbers them") {
  const VehicleStatus s = flying();
  const auto m =
      client::read(encode(Telemetry{msg::kAvailableModes, s, 3}, Envelope{}), mavlink_msg_available_modes_decode);
  CHECK(+m.number_modes == 6);
  CHECK(+m.mode_index == 3);
  CHECK(+m.custom_mode == 84148224);
  CHECK(+m.standard_mode == 5);
  CHECK(std::string(m.mode_name) == "Return");
  for (int i = 0; i < kWireModeCount; ++i) CHECK(static_cast<int>(kWireModes[i].mode) == i);
}

TEST_CASE("capabilities are exactly those that work") {
  const auto m = shown(msg::kAutopilotVersion, flying(), mavlink_msg_autopilot_version_decode);
  CHECK(+m.capabilities == 1 + 2 + 4 + 8 + 64 + 128 + 256 + 2048 + 8192);
  CHECK((m.flight_sw_version >> 24U) >= 2);
  CHECK((m.flight_sw_version & 0xFFU) == 0);
  CHECK(+m.uid != 0);
}

TEST_CASE("odometry gives velocity along the body's own axes") {
  VehicleStatus s = flying();
  const float half = std::sqrt(0.5F);
  s.estimate.q_WB = {half, 0, 0, half};  // nose to the west
  s.estimate.v_WB = {0, 2, 0};           // going west
  const auto m = shown(msg::kOdometry, s, mavlink_msg_odometry_decode);
  CHECK(+m.vx == doctest::Approx(2.F));
  CHECK(+m.vy == doctest::Approx(0.F));
}

TEST_CASE("numbers beyond a wire integer stop at its end") {
  VehicleStatus s = flying();
  s.estimate.v_WB = {1e6F, -1e6F, NAN};
  const auto m = shown(msg::kGlobalPositionInt, s, mavlink_msg_global_position_int_decode);
  CHECK(+m.vx == INT16_MAX);
  CHECK(+m.vy == INT16_MAX);
  CHECK(+m.vz == 0);
}
