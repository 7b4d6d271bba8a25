#include "sim/sensors.hpp"

#include <cmath>

namespace halfroll::sim {
namespace {

Vec3d normal3(Noise& noise, double deviation) {
  const double x = noise.normal(), y = noise.normal(), z = noise.normal();
  return Vec3d(x, y, z) * deviation;
}

PoseFix take_pose(const Scenario& scenario, Sensors& sensors, std::uint64_t t_us, const RigidBody& body) {
  const double kept = std::exp(-1e-6 * static_cast<double>(scenario.pose_period_us) / scenario.attitude_wander_time);
  sensors.attitude_wander =
      kept * sensors.attitude_wander + normal3(sensors.noise, scenario.attitude_wander * std::sqrt(1.0 - kept * kept));
  const Vec3d p_WB = body.p_WB + normal3(sensors.noise, scenario.position_noise);
  const Vec3d half = 0.5 * (sensors.attitude_wander + normal3(sensors.noise, scenario.attitude_noise));
  const Eigen::Vector4d q = product(body.q_WB, {1.0, half.x(), half.y(), half.z()}).normalized();
  const auto f = [](double x) { return static_cast<float>(x); };
  PoseFix pose;
  pose.t_us = t_us;
  pose.p_WB = p_WB.cast<float>();
  pose.q_WB = {f(q[0]), f(q[1]), f(q[2]), f(q[3])};
  return pose;
}

}  // namespace

Sensors make_sensors(const Scenario& scenario, std::uint64_t seed) {
  Sensors sensors;
  sensors.noise.state = seed;
  sensors.attitude_wander = normal3(sensors.noise, scenario.attitude_wander);
  return sensors;
}

Measurements read(const Scenario& scenario, Sensors& sensors, std::uint64_t t_us, const RigidBody& body,
                  const Vec3d& specific_force_B) {
  Measurements readings;
  readings.imu.w_WB_B = (body.w_WB_B + normal3(sensors.noise, scenario.gyro_noise)).cast<float>();
  readings.imu.specific_force_B =
      (specific_force_B + normal3(sensors.noise, scenario.accelerometer_noise)).cast<float>();
  if (t_us % scenario.pose_period_us == 0) {
    sensors.poses[sensors.taken++ % Sensors::kOnTheWay] = take_pose(scenario, sensors, t_us, body);
  }
  const PoseFix& oldest = sensors.poses[sensors.delivered % Sensors::kOnTheWay];
  if (sensors.delivered < sensors.taken && t_us >= oldest.t_us + scenario.pose_delay_us) {
    readings.pose = oldest;
    ++sensors.delivered;
  }
  return readings;
}

}  // namespace halfroll::sim
