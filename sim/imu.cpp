#include "sim/imu.hpp"

#include <algorithm>
#include <cmath>

#include "core/trig.hpp"
#include "sim/wide.hpp"

namespace halfroll::sim {
namespace {

constexpr std::uint64_t kWalkPeriodUs = 10000;  // a bias takes a step a hundred times a second
constexpr double kDtS = 1e-3;
constexpr double kTurn = 2.0 * 3.14159265358979323846;

/// Once a revolution each rotor shakes the frame: a turning force in its plane, as large along its axis. Grows with
/// speed squared. In units of one rotor's amplitude at nominal speed.
Vec3d shaking(Sensors& sensors, const Truth& truth) {
  Vec3d sum = Vec3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const double speed = truth.rotor_speed_rad_s[i], share = speed / truth.nominal_rotor_speed_rad_s;
    double& angle = sensors.rotor_angle[i];
    angle += speed * kDtS;
    if (angle > kTurn) angle -= kTurn * std::floor(angle / kTurn);
    const auto at = static_cast<float>(angle);
    const double c = static_cast<double>(cosine(at)), s = static_cast<double>(sine(at));
    sum += share * share * Vec3d(c, s, c);
  }
  return sum;
}

void walk(const InertialErrors& errors, Vec3d& bias, const Random& random, Stream stream, std::uint64_t t_us) {
  if (errors.bias_walk <= 0.0 || t_us == 0 || t_us % kWalkPeriodUs != 0) return;
  const auto n = random.normals<3>(stream, t_us / kWalkPeriodUs);
  bias += errors.bias_walk * std::sqrt(1e-6 * static_cast<double>(kWalkPeriodUs)) * Vec3d(n[0], n[1], n[2]);
}

Vec3 converted(const InertialErrors& errors, Vec3d reading) {
  if (errors.range > 0.0) reading = reading.cwiseMax(-errors.range).cwiseMin(errors.range);
  if (errors.step > 0.0) reading = ((reading / errors.step).array() + 0.5).floor() * errors.step;
  return reading.cast<float>();
}

Vec3d noisy(const InertialErrors& errors, const Random& random, Stream stream, std::uint64_t t_us, const Vec3d& truth) {
  if (errors.noise <= 0.0) return truth;
  const auto n = random.normals<3>(stream, t_us / 1000);
  return truth + errors.noise * Vec3d(n[0], n[1], n[2]);
}

}  // namespace

HALFROLL_WIDE Imu read_imu(const Scenario& scenario, const Random& random, Sensors& sensors, const Truth& truth) {
  const InertialErrors &gyro = scenario.gyro, &accelerometer = scenario.accelerometer;
  walk(gyro, sensors.gyro_bias, random, Stream::kGyroBias, truth.t_us);
  walk(accelerometer, sensors.accelerometer_bias, random, Stream::kAccelerometerBias, truth.t_us);
  Vec3d rate = noisy(gyro, random, Stream::kGyro, truth.t_us, truth.w_B + sensors.gyro_bias);
  Vec3d force = noisy(accelerometer, random, Stream::kAccelerometer, truth.t_us,
                      truth.specific_force_B + sensors.accelerometer_bias);
  if ((gyro.vibration > 0.0 || accelerometer.vibration > 0.0) && truth.nominal_rotor_speed_rad_s > 0.0) {
    const Vec3d shaken = shaking(sensors, truth);
    rate += gyro.vibration * shaken;
    force += accelerometer.vibration * shaken;
  }
  return {converted(gyro, rate), converted(accelerometer, force)};
}

}  // namespace halfroll::sim
