#include "rotor_slopes.hpp"

namespace halfroll::planner {
namespace {

constexpr double kTorqueX[4] = {1.0, 0.0, -1.0, 0.0}, kTorqueY[4] = {0.0, 1.0, 0.0, -1.0},
                 kTorqueZ[4] = {-1.0, 1.0, -1.0, 1.0};

}  // namespace

RotorSlopes rotor_slopes(const Flat<double>& flat, const Vehicle& vehicle) {
  const Dynamics<double> at = dynamics(flat, vehicle);
  const auto& J = vehicle.inertia;
  const auto& w = at.body.w;
  RotorSlopes out;
  out.thrusts = at.thrust;
  for (int i = 0; i < 4; ++i) {
    const double x = kTorqueX[i] * 0.5 / vehicle.arm, y = kTorqueY[i] * 0.5 / vehicle.arm,
                 z = kTorqueZ[i] * 0.25 / vehicle.yaw_coefficient;
    const Vec<double> u = {x * J[0], y * J[1], z * J[2]};  // on dw
    const double gx = x * (J[2] - J[1]), gy = y * (J[0] - J[2]), gz = z * (J[1] - J[0]);
    const Vec<double> v = {gy * w[2] + gz * w[1], gx * w[2] + gz * w[0], gx * w[1] + gy * w[0]};
    out.by[i] = pull_back(u, v, at);
    out.by[i].acceleration = out.by[i].acceleration + (0.25 * vehicle.mass) * at.axis.n;
  }
  return out;
}

}  // namespace halfroll::planner
