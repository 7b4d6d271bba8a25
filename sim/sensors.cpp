#include "sim/sensors.hpp"

#include <algorithm>
#include <cmath>

#include "sim/imu.hpp"
#include "sim/lag.hpp"

namespace halfroll::sim {
namespace {

constexpr double kPerMicrosecond = 1e-6;

Vec3d normal3(const Random& random, Stream stream, std::uint64_t index) {
  const auto n = random.normals<3>(stream, index);
  return {n[0], n[1], n[2]};
}

bool due(std::uint64_t period_us, std::uint64_t t_us) { return period_us > 0 && t_us % period_us == 0; }

bool happening(const Scenario& scenario, Fault::Kind kind, std::uint64_t t_us) {
  const double t_s = kPerMicrosecond * static_cast<double>(t_us);
  return std::any_of(scenario.faults.begin(), scenario.faults.end(),
                     [&](const Fault& fault) { return fault.kind == kind && fault.active(t_s); });
}

/// An Ornstein-Uhlenbeck process of this deviation, one period later.
Vec3d wandered(const Vec3d& before, const Vec3d& deviation, double period_s, double time, const Vec3d& normal) {
  const double lost = covered(period_s, time), kept = 1.0 - lost;
  return kept * before + std::sqrt(lost * (1.0 + kept)) * deviation.cwiseProduct(normal);
}

Eigen::Vector4d turned_by(const Eigen::Vector4d& q_WB, const Vec3d& small) {
  const Vec3d half = 0.5 * small;
  return product(q_WB, {1.0, half.x(), half.y(), half.z()}).normalized();
}

PoseFix pose_of(std::uint64_t t_us, const Vec3d& p_W, const Eigen::Vector4d& q) {
  const auto f = [](double x) { return static_cast<float>(x); };
  PoseFix pose;
  pose.t_us = t_us;
  pose.p_WB = p_W.cast<float>();
  pose.q_WB = {f(q[0]), f(q[1]), f(q[2]), f(q[3])};
  return pose;
}

/// One exposure of the motion capture: noise, outliers, dropouts, and when it will be there.
void expose(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth) {
  const MocapSetup& mocap = scenario.mocap;
  const std::uint64_t n = truth.t_us / mocap.period_us;
  Vec3d p_W = truth.p_W;
  Vec3d turn = Vec3d::Zero();
  if (mocap.position_noise > 0.0) p_W += mocap.position_noise * normal3(random, Stream::kMocapPosition, n);
  if (mocap.attitude_noise > 0.0) turn += mocap.attitude_noise * normal3(random, Stream::kMocapAttitude, n);
  if (mocap.attitude_wander > 0.0) {
    const double period_s = kPerMicrosecond * static_cast<double>(mocap.period_us);
    sensors.attitude_wander = wandered(sensors.attitude_wander, Vec3d::Constant(mocap.attitude_wander), period_s,
                                       mocap.wander_time, normal3(random, Stream::kMocapWander, n + 1));
    turn += sensors.attitude_wander;
  }
  std::uint64_t due_us = truth.t_us + mocap.delay_us;
  bool seen = !happening(scenario, Fault::Kind::kMocapLost, truth.t_us);
  if (mocap.dropout > 0.0 || mocap.outlier > 0.0 || mocap.jitter_us > 0) {
    const auto u = random.uniforms(Stream::kMocapDelivery, n);
    seen = seen && u[0] >= mocap.dropout;
    due_us += static_cast<std::uint64_t>(u[1] * static_cast<double>(mocap.jitter_us));
    if (u[2] < mocap.outlier) {
      const auto wrong = random.normals<3>(Stream::kMocapOutlier, 2 * n);
      p_W += mocap.outlier_size * Vec3d(wrong[0], wrong[1], wrong[2]);
      turn += mocap.outlier_size * normal3(random, Stream::kMocapOutlier, 2 * n + 1);
    }
  }
  PoseFix pose = pose_of(truth.t_us, p_W, turn.isZero(0.0) ? truth.q_WB : turned_by(truth.q_WB, turn));
  if (happening(scenario, Fault::Kind::kMocapFrozen, truth.t_us)) {
    pose = sensors.last_pose;
    pose.t_us = truth.t_us;
  }
  sensors.last_pose = pose;
  if (seen) sensors.poses.send(pose, due_us);
}

void fix_position(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth) {
  const GpsSetup& gps = scenario.gps;
  const std::uint64_t n = truth.t_us / gps.period_us;
  const double period_s = kPerMicrosecond * static_cast<double>(gps.period_us);
  sensors.gps_wander = wandered(sensors.gps_wander, {gps.wander_xy, gps.wander_xy, gps.wander_z}, period_s,
                                gps.wander_time, normal3(random, Stream::kGpsWander, n + 1));
  if (happening(scenario, Fault::Kind::kGpsLost, truth.t_us)) return;
  const Vec3d white = normal3(random, Stream::kGpsPosition, n);
  const Vec3d error = sensors.gps_wander + Vec3d(gps.noise_xy, gps.noise_xy, gps.noise_z).cwiseProduct(white);
  GpsFix fix;
  fix.t_us = truth.t_us;
  fix.p_WB = (truth.p_W + error).cast<float>();
  fix.v_WB = (truth.v_W + gps.velocity_noise * normal3(random, Stream::kGpsVelocity, n)).cast<float>();
  fix.horizontal_deviation = static_cast<float>(std::hypot(gps.noise_xy, gps.wander_xy));
  fix.vertical_deviation = static_cast<float>(std::hypot(gps.noise_z, gps.wander_z));
  fix.speed_deviation = static_cast<float>(gps.velocity_noise);
  sensors.fixes.send(fix, truth.t_us + gps.delay_us);
}

BarometerSample pressure_height(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth) {
  const BarometerSetup& barometer = scenario.barometer;
  const double period_s = kPerMicrosecond * static_cast<double>(barometer.period_us);
  const auto n = random.normals<2>(Stream::kBarometer, truth.t_us / barometer.period_us);
  sensors.barometer_drift += barometer.drift * std::sqrt(period_s) * n[0];
  return {truth.t_us, static_cast<float>(truth.p_W.z() + sensors.barometer_drift + barometer.noise * n[1])};
}

MagnetometerSample field(const Scenario& scenario, const Random& random, const Sensors& sensors, const Truth& truth) {
  const MagnetometerSetup& magnetometer = scenario.magnetometer;
  const Vec3d noise =
      magnetometer.noise * normal3(random, Stream::kMagnetometer, truth.t_us / magnetometer.period_us + 1);
  const Vec3d field_B = rotation(truth.q_WB).transpose() * magnetic_field_W() + sensors.magnetometer_bias + noise;
  return {truth.t_us, field_B.cast<float>()};
}

}  // namespace

Vec3d magnetic_field_W() { return {0.45399049973954675, 0.0, -0.8910065241883679}; }

Sensors make_sensors(const Scenario& scenario, const Random& random) {
  Sensors sensors;
  sensors.gyro_bias = scenario.gyro.bias * normal3(random, Stream::kGyroBias, 0);
  sensors.accelerometer_bias = scenario.accelerometer.bias * normal3(random, Stream::kAccelerometerBias, 0);
  sensors.attitude_wander = scenario.mocap.attitude_wander * normal3(random, Stream::kMocapWander, 0);
  const GpsSetup& gps = scenario.gps;
  sensors.gps_wander =
      Vec3d(gps.wander_xy, gps.wander_xy, gps.wander_z).cwiseProduct(normal3(random, Stream::kGpsWander, 0));
  const auto turns = random.uniforms(Stream::kVibration, 0);
  for (std::size_t i = 0; i < 4; ++i) sensors.rotor_angle[i] = 360.0 * kDegree * turns[i];
  sensors.magnetometer_bias = scenario.magnetometer.bias * normal3(random, Stream::kMagnetometer, 0);
  return sensors;
}

Measurements read(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth) {
  Measurements readings;
  readings.imu = read_imu(scenario, random, sensors, truth);
  if (due(scenario.mocap.period_us, truth.t_us)) expose(scenario, random, sensors, truth);
  readings.pose = sensors.poses.deliver(truth.t_us);
  if (due(scenario.gps.period_us, truth.t_us)) fix_position(scenario, random, sensors, truth);
  readings.gps = sensors.fixes.deliver(truth.t_us);
  if (due(scenario.barometer.period_us, truth.t_us)) {
    readings.barometer = pressure_height(scenario, random, sensors, truth);
  }
  if (due(scenario.magnetometer.period_us, truth.t_us)) {
    readings.magnetometer = field(scenario, random, sensors, truth);
  }
  return readings;
}

}  // namespace halfroll::sim
