#include "sim/rigid_body.hpp"

namespace halfroll::sim {

Eigen::Matrix3d rotation(const Eigen::Vector4d& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Eigen::Matrix3d r;
  r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return r;
}

Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

RigidBody rate(const Plant& plant, const RigidBody& body, const Load& load) {
  const Vec3d& w = body.w_WB_B;
  const Vec3d momentum_B = plant.inertia.cwiseProduct(w);
  RigidBody dot;
  dot.p_WB = body.v_WB;
  dot.v_WB = load.force_W / plant.mass;
  dot.q_WB = 0.5 * product(body.q_WB, {0.0, w.x(), w.y(), w.z()});
  dot.w_WB_B = (load.torque_B - w.cross(momentum_B)).cwiseQuotient(plant.inertia);
  return dot;
}

RigidBody moved(const RigidBody& body, const RigidBody& rate, double h) {
  return {body.p_WB + h * rate.p_WB, body.v_WB + h * rate.v_WB, body.q_WB + h * rate.q_WB,
          body.w_WB_B + h * rate.w_WB_B};
}

RigidBody runge_kutta_mean(const RigidBody& k1, const RigidBody& k2, const RigidBody& k3, const RigidBody& k4) {
  const auto mean = [](const auto& a, const auto& b, const auto& c, const auto& d) {
    return ((a + 2.0 * (b + c) + d) / 6.0).eval();
  };
  return {mean(k1.p_WB, k2.p_WB, k3.p_WB, k4.p_WB), mean(k1.v_WB, k2.v_WB, k3.v_WB, k4.v_WB),
          mean(k1.q_WB, k2.q_WB, k3.q_WB, k4.q_WB), mean(k1.w_WB_B, k2.w_WB_B, k3.w_WB_B, k4.w_WB_B)};
}

}  // namespace halfroll::sim
