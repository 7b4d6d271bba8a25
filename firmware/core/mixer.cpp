#include "core/mixer.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace halfroll {

// Rotors 1 and 3 share roll, 2 and 4 pitch: with the differences u = f1 - f3 and v = f2 - f4 settled, the sums of the
// pairs have plain bounds, total thrust is their sum and yaw their difference. So each step is a clip, never a search.
Allocation allocate(const Wrench& wrench, const Vehicle& vehicle) {
  const float least = vehicle.thrust_min, most = vehicle.thrust_max;
  float u = wrench.torque.x() / vehicle.arm;
  float v = wrench.torque.y() / vehicle.arm;
  float y = wrench.torque.z() / vehicle.yaw_coefficient;  // (f2 + f4) - (f1 + f3)
  float thrust = wrench.thrust;
  Saturation cut;
  if (!std::isfinite(u + v + y + thrust)) {
    u = v = y = 0.F;
    thrust = vehicle.mass * kGravity;
    cut = {true, true, true};
  }

  const float widest = std::max(std::abs(u), std::abs(v)), range = most - least;  // 1: roll and pitch, direction kept
  if (widest > range) {
    u *= range / widest;
    v *= range / widest;
    cut.tilt = true;
  }

  const float least13 = 2.F * least + std::abs(u), most13 = 2.F * most - std::abs(u);  // bounds of f1 + f3
  const float least24 = 2.F * least + std::abs(v), most24 = 2.F * most - std::abs(v);  // bounds of f2 + f4
  const float wanted_thrust = thrust;                                                  // 2: total thrust
  thrust = std::min(std::max(thrust, least13 + least24), most13 + most24);
  cut.thrust = cut.thrust || thrust != wanted_thrust;

  const float wanted_y = y;  // 3: yaw gets the rest
  y = std::min(std::max({y, thrust - 2.F * most13, 2.F * least24 - thrust}),
               std::min(thrust - 2.F * least13, 2.F * most24 - thrust));
  cut.yaw = cut.yaw || y != wanted_y;

  const float sum13 = 0.5F * (thrust - y), sum24 = 0.5F * (thrust + y);
  Allocation given;
  given.cut = cut;
  given.rotors.thrust = {0.5F * (sum13 + u), 0.5F * (sum24 + v), 0.5F * (sum13 - u), 0.5F * (sum24 - v)};
  for (float& f : given.rotors.thrust) f = std::min(std::max(f, least), most);  // against rounding
  return given;
}

Wrench mix(const RotorCommands& rotors, const Vehicle& vehicle) {
  const auto& f = rotors.thrust;
  return {f[0] + f[1] + f[2] + f[3], Vec3(vehicle.arm * (f[0] - f[2]), vehicle.arm * (f[1] - f[3]),
                                          vehicle.yaw_coefficient * (-f[0] + f[1] - f[2] + f[3]))};
}

}  // namespace halfroll
