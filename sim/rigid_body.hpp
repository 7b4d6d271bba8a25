// A rigid body under forces and torques. Why: equations of motion stand here once, apart from what pushes the body.
// Everything is inline: sixteen evaluations make a simulated millisecond.
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

/// Mass and inertia about the centre of mass, with what is divided by them at every step.
class Inertia {
 public:
  Inertia(double mass, const Eigen::Matrix3d& moments)
      : mass_(mass),
        per_mass_(1.0 / mass),
        moments_(moments),
        per_moments_(moments.inverse()),
        diagonal_(moments.isDiagonal(0.0)),
        per_principal_(per_moments_.diagonal()),
        difference_(moments(2, 2) - moments(1, 1), moments(0, 0) - moments(2, 2), moments(1, 1) - moments(0, 0)) {}
  Inertia(double mass, const Vec3d& principal) : Inertia(mass, Eigen::Matrix3d(principal.asDiagonal())) {}

  double mass() const { return mass_; }
  double per_mass() const { return per_mass_; }
  const Eigen::Matrix3d& moments() const { return moments_; }

  /// Angular acceleration: J dw = M - w x J w  (paper Eq 3).
  Vec3d turned(const Vec3d& w, const Vec3d& torque) const {
    if (diagonal_) {
      return {(torque.x() - difference_.x() * w.y() * w.z()) * per_principal_.x(),
              (torque.y() - difference_.y() * w.z() * w.x()) * per_principal_.y(),
              (torque.z() - difference_.z() * w.x() * w.y()) * per_principal_.z()};
    }
    return per_moments_ * (torque - w.cross(moments_ * w));
  }

 private:
  double mass_, per_mass_;
  Eigen::Matrix3d moments_, per_moments_;
  bool diagonal_;
  Vec3d per_principal_, difference_;
};

/// R(q), body to world.
inline Eigen::Matrix3d rotation(const Eigen::Vector4d& q) {
  const double x = 2 * q[1], y = 2 * q[2], z = 2 * q[3];
  const double wx = q[0] * x, wy = q[0] * y, wz = q[0] * z, xx = q[1] * x, xy = q[1] * y, xz = q[1] * z, yy = q[2] * y,
               yz = q[2] * z, zz = q[3] * z;
  Eigen::Matrix3d r;
  r << 1 - (yy + zz), xy - wz, xz + wy,  //
      xy + wz, 1 - (xx + zz), yz - wx,   //
      xz - wy, yz + wx, 1 - (xx + yy);
  return r;
}

/// Third column of R(q): the body's up axis in W.
inline Vec3d up_axis(const Eigen::Vector4d& q) {
  const double x = 2 * q[1], y = 2 * q[2];
  return {x * q[3] + q[0] * y, y * q[3] - q[0] * x, 1 - (q[1] * x + q[2] * y)};
}

/// Hamilton product, [w, x, y, z].
inline Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

/// q (0, w) / 2, the time derivative of an attitude.
inline Eigen::Vector4d attitude_rate(const Eigen::Vector4d& q, const Vec3d& w) {
  const Vec3d half = 0.5 * w;
  return {-q[1] * half.x() - q[2] * half.y() - q[3] * half.z(), q[0] * half.x() + q[2] * half.z() - q[3] * half.y(),
          q[0] * half.y() + q[3] * half.x() - q[1] * half.z(), q[0] * half.z() + q[1] * half.y() - q[2] * half.x()};
}

/// Where in a step a load is asked for.
enum class Moment : std::uint8_t { kBegin, kMiddle, kEnd };

/// One classical Runge-Kutta step of h seconds (paper Eqs 2 and 3, corrected); load(body, moment) is asked four times.
/// The attitude comes out of unit length: what a step adds, at most (|w| h)^6 / 144, is taken off to first order.
template <typename LoadOf>
inline void rk4(const Inertia& inertia, RigidBody& body, const LoadOf& load, double h) {
  struct Rate {
    Vec3d v, a;
    Eigen::Vector4d q;
    Vec3d w;
  };
  const auto rate = [&](const RigidBody& at, Moment moment) -> Rate {
    const Load sum = load(at, moment);
    return {at.v_WB, sum.force_W * inertia.per_mass(), attitude_rate(at.q_WB, at.w_WB_B),
            inertia.turned(at.w_WB_B, sum.torque_B)};
  };
  const auto moved = [&](const Rate& k, double step) -> RigidBody {
    return {body.p_WB + step * k.v, body.v_WB + step * k.a, body.q_WB + step * k.q, body.w_WB_B + step * k.w};
  };
  const Rate k1 = rate(body, Moment::kBegin);
  const Rate k2 = rate(moved(k1, 0.5 * h), Moment::kMiddle);
  const Rate k3 = rate(moved(k2, 0.5 * h), Moment::kMiddle);
  const Rate k4 = rate(moved(k3, h), Moment::kEnd);
  const double sixth = h / 6.0;
  body.p_WB += sixth * (k1.v + 2.0 * (k2.v + k3.v) + k4.v);
  body.v_WB += sixth * (k1.a + 2.0 * (k2.a + k3.a) + k4.a);
  body.q_WB += sixth * (k1.q + 2.0 * (k2.q + k3.q) + k4.q);
  body.w_WB_B += sixth * (k1.w + 2.0 * (k2.w + k3.w) + k4.w);
  body.q_WB *= 1.5 - 0.5 * body.q_WB.squaredNorm();
}

}  // namespace halfroll::sim
