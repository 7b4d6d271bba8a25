// What the core tests compare with. Why: formulas are checked against Eigen's quaternions and finite differences in
// double, never against themselves; the vehicle is the paper's.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace oracle {

using Vec3d = Eigen::Vector3d;
using Quatd = Eigen::Quaterniond;

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;
inline constexpr double kGravity = 9.81;

inline halfroll::Vehicle paper_vehicle() {
  halfroll::Vehicle v;
  v.mass = 0.571F;
  v.inertia = {0.00365F, 0.00365F, 0.0068F};
  v.arm = 0.175F;
  v.yaw_coefficient = 0.010F;
  v.rotor_kind = halfroll::RotorKind::kVariablePitch;
  v.thrust_min = -3.F;
  v.thrust_max = 3.F;
  v.rotor_lag = v.rotor_lag_down = 0.018F;
  return v;
}

inline halfroll::Vehicle fixed_pitch_vehicle() {
  halfroll::Vehicle v = paper_vehicle();
  v.rotor_kind = halfroll::RotorKind::kFixedPitch;
  v.thrust_min = 0.15F;
  v.rotor_lag = v.rotor_lag_down = 0.12F;
  return v;
}

inline halfroll::Quat to_core(const Quatd& q) {
  return {static_cast<float>(q.w()), static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z())};
}
inline Quatd from_core(const halfroll::Quat& q) { return {q.w, q.x, q.y, q.z}; }

inline Quatd turn(const Vec3d& v) {
  const double angle = v.norm();
  return angle > 0.0 ? Quatd(Eigen::AngleAxisd(angle, v / angle)) : Quatd::Identity();
}

/// Angle between two attitudes [rad]; q and -q are one.
inline double angle_between(const Quatd& a, const Quatd& b) {
  const Quatd e = a.conjugate() * b;
  return 2.0 * std::atan2(e.vec().norm(), std::abs(e.w()));
}
inline double angle_between(const halfroll::Quat& a, const halfroll::Quat& b) {
  return angle_between(from_core(a).normalized(), from_core(b).normalized());
}

/// Body rate of q(t) by central differences.
template <class Attitude>
Vec3d body_rate(const Attitude& q, double t, double h = 1e-5) {
  Quatd before = q(t - h), after = q(t + h);
  const Quatd e = before.conjugate() * after;
  return (e.w() < 0.0 ? -2.0 : 2.0) * e.vec() / (2.0 * h);
}

struct Random {
  std::mt19937 generator;
  explicit Random(unsigned seed) : generator(seed) {}
  double uniform(double least, double most) {
    return least + (most - least) * static_cast<double>(generator()) / 4294967295.0;
  }
  double normal() {  // sum of twelve: portable, unlike std::normal_distribution
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform(0.0, 1.0);
    return sum;
  }
  Vec3d normal3(double size) {
    const double x = normal(), y = normal(), z = normal();
    return size * Vec3d(x, y, z);
  }
  Quatd attitude() {
    const double w = normal(), x = normal(), y = normal(), z = normal();
    return Quatd(w, x, y, z).normalized();
  }
};

}  // namespace oracle
