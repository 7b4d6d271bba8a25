// A vehicle in the air, in double: what a closed loop of the kernels flies. Why: the simulator is not the oracle of the
// core.
#pragma once
#include <deque>

#include "oracle.hpp"

namespace oracle {

inline constexpr double kStep = 1e-3;

/// Rigid body and rotors: dead time, lag and slew of blades, or the lag of motor speed.
class FlyingBody {
 public:
  explicit FlyingBody(const halfroll::Vehicle& vehicle) : vehicle_(vehicle) {
    thrust_.setConstant(0.25 * vehicle.mass * kGravity);
    for (int i = 0; i < 3; ++i) on_its_way_.push_back(thrust_);
  }

  Vec3d p = Vec3d::Zero(), v = Vec3d::Zero(), w = Vec3d::Zero();
  Quatd q = Quatd::Identity();

  void step(const halfroll::RotorCommands& command) {
    const Eigen::Vector4d before = thrust_;
    turn_rotors({command.thrust[0], command.thrust[1], command.thrust[2], command.thrust[3]});
    const Eigen::Vector4d f = 0.5 * (before + thrust_);
    const double d = vehicle_.arm, c = vehicle_.yaw_coefficient;
    const Vec3d torque(d * (f[0] - f[2]), d * (f[1] - f[3]), c * (-f[0] + f[1] - f[2] + f[3]));
    const Vec3d inertia = vehicle_.inertia.cast<double>();
    const Vec3d dw = (torque - w.cross(inertia.cwiseProduct(w))).cwiseQuotient(inertia);
    const Quatd halfway = q * turn((w + 0.25 * kStep * dw) * 0.5 * kStep);
    const Vec3d a = halfway * Vec3d(0.0, 0.0, f.sum() / vehicle_.mass) - Vec3d(0.0, 0.0, kGravity);
    p += kStep * v + 0.5 * kStep * kStep * a;
    v += kStep * a;
    q = (q * turn((w + 0.5 * kStep * dw) * kStep)).normalized();
    w += kStep * dw;
  }

  /// What an accelerometer shows now.
  Vec3d specific_force() const { return {0.0, 0.0, thrust_.sum() / vehicle_.mass}; }

 private:
  void turn_rotors(const Eigen::Vector4d& command) {
    if (vehicle_.rotor_kind == halfroll::RotorKind::kFixedPitch) {
      const double share = 1.0 - std::exp(-kStep / vehicle_.rotor_lag);
      const Eigen::Vector4d speed = thrust_.cwiseSqrt();
      thrust_ = (speed + share * (command.cwiseSqrt() - speed)).cwiseAbs2();
      return;
    }
    on_its_way_.push_back(command);
    const double share = 1.0 - std::exp(-kStep / 0.018), most = 126.0 * kStep;
    thrust_ += (share * (on_its_way_.front() - thrust_)).cwiseMax(-most).cwiseMin(most);
    on_its_way_.pop_front();
  }

  halfroll::Vehicle vehicle_;
  Eigen::Vector4d thrust_;
  std::deque<Eigen::Vector4d> on_its_way_;
};

}  // namespace oracle
