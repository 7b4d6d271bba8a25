// A rigid body under forces and torques. Why: equations of motion stand here once, apart from what pushes the body.
#pragma once
#include "sim/plant.hpp"

namespace halfroll::sim {

/// Position, velocity, attitude [w, x, y, z] (Hamilton, unit, body to world) and body rate.
struct RigidBody {
  Vec3d p_WB = Vec3d::Zero();
  Vec3d v_WB = Vec3d::Zero();
  Eigen::Vector4d q_WB = {1.0, 0.0, 0.0, 0.0};
  Vec3d w_WB_B = Vec3d::Zero();
};

/// Everything that acts on a body; gravity included by the one who sums up.
struct Load {
  Vec3d force_W = Vec3d::Zero();
  Vec3d torque_B = Vec3d::Zero();
};

/// R(q), body to world.
Eigen::Matrix3d rotation(const Eigen::Vector4d& q);

/// Hamilton product, [w, x, y, z].
Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q);

/// Time derivative of every member (paper Eqs 2 and 3, corrected; qdot = q (0, w) / 2).
RigidBody rate(const Plant& plant, const RigidBody& body, const Load& load);

/// body + rate h, member by member; the attitude is left off unit length.
RigidBody moved(const RigidBody& body, const RigidBody& rate, double h);

/// (k1 + 2 k2 + 2 k3 + k4) / 6, member by member.
RigidBody runge_kutta_mean(const RigidBody& k1, const RigidBody& k2, const RigidBody& k3, const RigidBody& k4);

/// One classical Runge-Kutta step of h seconds; load(body) is asked four times.
template <typename LoadOf>
RigidBody rk4(const Plant& plant, const RigidBody& body, const LoadOf& load, double h) {
  const RigidBody k1 = rate(plant, body, load(body));
  const RigidBody at_2 = moved(body, k1, 0.5 * h);
  const RigidBody k2 = rate(plant, at_2, load(at_2));
  const RigidBody at_3 = moved(body, k2, 0.5 * h);
  const RigidBody k3 = rate(plant, at_3, load(at_3));
  const RigidBody at_4 = moved(body, k3, h);
  const RigidBody k4 = rate(plant, at_4, load(at_4));
  RigidBody next = moved(body, runge_kutta_mean(k1, k2, k3, k4), h);
  next.q_WB.normalize();
  return next;
}

}  // namespace halfroll::sim
