#include "sim/sitl/px4_topics.hpp"

#include <algorithm>
#include <cmath>

#include "core/modes.hpp"
#include "sim/sitl/flight_log.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::uint64_t kFastUs = 4000, kMediumUs = 10000, kSlowUs = 100000, kStatusUs = 500000;
constexpr int kOutputs = 16, kMotors = 12;  // as many as PX4 has room for
constexpr float kLowBattery = 0.2F;

void put(Ulog& ulog, const Vec3& v) {
  for (const float x : v) ulog.put(x);
}
void put(Ulog& ulog, const Quat& q) {
  for (const float x : {q.w, q.x, q.y, q.z}) ulog.put(x);
}

Vec3 single(const sim::Vec3d& v) { return v.cast<float>(); }
Quat single(const Eigen::Vector4d& q) {
  const Eigen::Vector4f f = q.cast<float>();
  return {f[0], f[1], f[2], f[3]};
}

/// PX4's number of a mode, vehicle_status.nav_state.
std::uint8_t nav_state(std::uint8_t mode) {
  switch (static_cast<Mode>(mode)) {
    case Mode::kMission: return 3;
    case Mode::kReturn: return 5;
    case Mode::kLand: return 18;
    case Mode::kTakeoff: return 17;
    case Mode::kOffboard: return 14;
    default: return 4;  // loiter
  }
}

}  // namespace

Px4Topics::Px4Topics(Ulog& ulog, const sim::Plant& plant, const link::Origin& origin, float thrust_reference,
                     int system_id)
    : origin_(origin),
      thrust_max_(static_cast<float>(plant.thrust_max)),
      thrust_reference_(thrust_reference),
      reversible_(plant.thrust_min < 0.0),
      capacity_Ah_(plant.battery_capacity_Ah),
      system_id_(static_cast<std::uint8_t>(system_id)) {
  attitude_ = ulog.add_topic("vehicle_attitude", "uint64_t timestamp_sample;float[4] q;");
  rates_ = ulog.add_topic("vehicle_angular_velocity", "uint64_t timestamp_sample;float[3] xyz;");
  attitude_truth_ = ulog.add_topic("vehicle_attitude_groundtruth", "uint64_t timestamp_sample;float[4] q;");
  rates_truth_ = ulog.add_topic("vehicle_angular_velocity_groundtruth", "uint64_t timestamp_sample;float[3] xyz;");
  attitude_setpoint_ =
      ulog.add_topic("vehicle_attitude_setpoint", "float yaw_sp_move_rate;float[4] q_d;float[3] thrust_body;");
  rates_setpoint_ = ulog.add_topic("vehicle_rates_setpoint", "float roll;float pitch;float yaw;float[3] thrust_body;");
  sensors_ = ulog.add_topic("sensor_combined", "float[3] gyro_rad;float[3] accelerometer_m_s2;");
  motors_ = ulog.add_topic("actuator_motors", "uint64_t timestamp_sample;float[12] control;uint16_t reversible_flags;");
  const std::string local =
      "uint64_t timestamp_sample;uint64_t ref_timestamp;double ref_lat;double ref_lon;float x;float y;float z;float vx;"
      "float vy;float vz;float heading;float ref_alt;float eph;float epv;float evh;float evv;uint8_t xy_valid;"
      "uint8_t z_valid;uint8_t v_xy_valid;uint8_t v_z_valid;uint8_t xy_global;uint8_t z_global;";
  position_ = ulog.add_topic("vehicle_local_position", local);
  position_truth_ = ulog.add_topic("vehicle_local_position_groundtruth", local);
  global_ = ulog.add_topic("vehicle_global_position", "double lat;double lon;float alt;float eph;float epv;");
  outputs_ = ulog.add_topic("actuator_outputs", "uint32_t noutputs;float[16] output;");
  battery_ = ulog.add_topic("battery_status",
                            "float voltage_v;float voltage_filtered_v;float current_a;float discharged_mah;"
                            "float remaining;uint8_t connected;uint8_t warning;");
  status_ = ulog.add_topic("vehicle_status",
                           "uint64_t armed_time;uint8_t arming_state;uint8_t nav_state;uint8_t vehicle_type;"
                           "uint8_t system_type;uint8_t system_id;uint8_t component_id;uint8_t is_vtol;");
}

void Px4Topics::add(Ulog& ulog, const FlightRecord& r) {
  if (r.t_us % kFastUs == 0) add_attitude(ulog, r);
  if (r.t_us % kMediumUs == 0) add_position(ulog, r);
  if (r.t_us % kSlowUs == 0) add_battery(ulog, r);
  add_status(ulog, r);
}

void Px4Topics::add_attitude(Ulog& ulog, const FlightRecord& r) const {
  const auto turn = [&](Ulog::Topic topic, const auto& quantity) {
    ulog.begin(topic, r.t_us);
    ulog.put(r.t_us);
    put(ulog, link::to_wire(quantity));
    ulog.end();
  };
  turn(attitude_, r.estimate.q_WB);
  turn(rates_, r.estimate.w_WB_B);
  turn(attitude_truth_, single(r.truth.body.q_WB));
  turn(rates_truth_, single(r.truth.body.w_WB_B));

  const Vec3 w_WD_D = link::to_wire(r.reference.w_WD_D), thrust(0.F, 0.F, -r.reference.thrust / thrust_reference_);
  ulog.begin(attitude_setpoint_, r.t_us);
  ulog.put(link::to_wire(rotate(r.reference.q_WD, r.reference.w_WD_D)).z());
  put(ulog, link::to_wire(r.reference.q_WD));
  put(ulog, thrust);
  ulog.end();
  ulog.begin(rates_setpoint_, r.t_us);
  put(ulog, w_WD_D);
  put(ulog, thrust);
  ulog.end();

  ulog.begin(sensors_, r.t_us);
  put(ulog, link::to_wire(r.truth.readings.imu.w_WB_B));
  put(ulog, link::to_wire(r.truth.readings.imu.specific_force_B));
  ulog.end();

  ulog.begin(motors_, r.t_us);
  ulog.put(r.t_us);
  for (int i = 0; i < kMotors; ++i) {
    ulog.put(i < 4 ? r.commands.thrust[static_cast<std::size_t>(i)] / thrust_max_ : std::nanf(""));
  }
  ulog.put(static_cast<std::uint16_t>(reversible_ ? 0xF : 0));
  ulog.end();
}

void Px4Topics::add_position(Ulog& ulog, const FlightRecord& r) const {
  const auto local = [&](Ulog::Topic topic, const Vec3& p_WB, const Vec3& v_WB, const Quat& q_WB, float position_sd,
                         float velocity_sd, bool valid) {
    ulog.begin(topic, r.t_us);
    ulog.put(r.t_us);
    ulog.put(std::uint64_t{0});
    ulog.put(1e-7 * origin_.lat_degE7());
    ulog.put(1e-7 * origin_.lon_degE7());
    put(ulog, link::to_wire(p_WB));
    put(ulog, link::to_wire(v_WB));
    ulog.put(link::wire_angles(q_WB).z());
    ulog.put(origin_.alt_m());
    for (const float sd : {position_sd, position_sd, velocity_sd, velocity_sd}) ulog.put(sd);
    for (int i = 0; i < 6; ++i) ulog.put(static_cast<std::uint8_t>(valid));
    ulog.end();
  };
  const Estimate& e = r.estimate;
  const sim::RigidBody& body = r.truth.body;
  local(position_, e.p_WB, e.v_WB, e.q_WB, e.position_deviation, e.velocity_deviation, e.position_valid);
  local(position_truth_, single(body.p_WB), single(body.v_WB), single(body.q_WB), 0.F, 0.F, true);

  ulog.begin(outputs_, r.t_us);
  ulog.put(std::uint32_t{4});
  for (int i = 0; i < kOutputs; ++i) {  // per mille of the largest thrust
    ulog.put(i < 4 ? 1000.F * r.commands.thrust[static_cast<std::size_t>(i)] / thrust_max_ : 0.F);
  }
  ulog.end();

  if (r.t_us % kSlowUs != 0) return;
  const link::GlobalPosition place = link::global_from_local(origin_, e.p_WB);
  ulog.begin(global_, r.t_us);
  ulog.put(1e-7 * place.lat_degE7);
  ulog.put(1e-7 * place.lon_degE7);
  ulog.put(1e-3F * static_cast<float>(place.alt_mm));
  for (int i = 0; i < 2; ++i) ulog.put(e.position_deviation);
  ulog.end();
}

void Px4Topics::add_battery(Ulog& ulog, const FlightRecord& r) {
  const sim::Battery& battery = r.truth.battery;
  const auto voltage = static_cast<float>(battery.voltage), remaining = static_cast<float>(battery.charge);
  ulog.begin(battery_, r.t_us);
  ulog.put(voltage);
  ulog.put(voltage);
  ulog.put(battery.voltage > 0.0 ? static_cast<float>(battery.power / battery.voltage) : 0.F);
  ulog.put(static_cast<float>(1e3 * capacity_Ah_ * (1.0 - battery.charge)));
  ulog.put(remaining);
  ulog.put(static_cast<std::uint8_t>(battery.voltage > 0.0));
  ulog.put(static_cast<std::uint8_t>(remaining < kLowBattery));
  ulog.end();
}

void Px4Topics::add_status(Ulog& ulog, const FlightRecord& r) {
  const int armed = r.armed ? 1 : 0;
  if (armed != last_armed_) armed_us_ = r.armed ? r.t_us : 0;
  if (r.mode == last_mode_ && armed == last_armed_ && r.t_us % kStatusUs != 0) return;
  last_mode_ = r.mode;
  last_armed_ = armed;
  ulog.begin(status_, r.t_us);
  ulog.put(armed_us_);
  ulog.put(static_cast<std::uint8_t>(1 + armed));  // 1 standby, 2 armed
  ulog.put(nav_state(r.mode));
  ulog.put(std::uint8_t{1});  // rotary wing
  ulog.put(std::uint8_t{2});  // MAV_TYPE_QUADROTOR
  ulog.put(system_id_);
  ulog.put(std::uint8_t{1});
  ulog.put(std::uint8_t{0});
  ulog.end();
}

}  // namespace halfroll::sitl
