// The kernels together, over the split: outer loop at 100 Hz with delays, firmware at 1 kHz, rotors with lag, a rigid
// body in double. Why: each term may be right and the loop still wrong; the numbers are those of the reference.
#include <doctest/doctest.h>

#include <deque>

#include "core/attitude.hpp"
#include "core/mixer.hpp"
#include "core/outer_loop.hpp"
#include "core/quaternion.hpp"
#include "core/rotor.hpp"
#include "core/setpoint.hpp"
#include "free_fall_flip.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::Quatd;
using oracle::Vec3d;

constexpr double kStep = 1e-3;
constexpr int kStateAge = 10, kLinkDelay = 2;  // [ms]
constexpr double kMidAge = 0.007;              // link delay and half a period

/// Rigid body and rotors: dead time, lag and slew of blades, or the lag of motor speed.
class Body {
 public:
  explicit Body(const Vehicle& vehicle) : vehicle_(vehicle) {
    thrust_.setConstant(0.25 * vehicle.mass * oracle::kGravity);
    for (int i = 0; i < 3; ++i) on_its_way_.push_back(thrust_);
  }

  Vec3d p = Vec3d::Zero(), v = Vec3d::Zero(), w = Vec3d::Zero();
  Quatd q = Quatd::Identity();

  void step(const RotorCommands& command) {
    const Eigen::Vector4d before = thrust_;
    turn_rotors({command.thrust[0], command.thrust[1], command.thrust[2], command.thrust[3]});
    const Eigen::Vector4d f = 0.5 * (before + thrust_);
    const double d = vehicle_.arm, c = vehicle_.yaw_coefficient;
    const Vec3d torque(d * (f[0] - f[2]), d * (f[1] - f[3]), c * (-f[0] + f[1] - f[2] + f[3]));
    const Vec3d inertia = vehicle_.inertia.cast<double>();
    const Vec3d a = q * Vec3d(0.0, 0.0, f.sum() / vehicle_.mass) - Vec3d(0.0, 0.0, oracle::kGravity);
    const Vec3d dw = (torque - w.cross(inertia.cwiseProduct(w))).cwiseQuotient(inertia);
    p += kStep * v + 0.5 * kStep * kStep * a;
    v += kStep * a;
    q = (q * oracle::turn((w + 0.5 * kStep * dw) * kStep)).normalized();
    w += kStep * dw;
  }

 private:
  void turn_rotors(const Eigen::Vector4d& command) {
    if (vehicle_.rotor_kind == RotorKind::kFixedPitch) {
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

  Vehicle vehicle_;
  Eigen::Vector4d thrust_;
  std::deque<Eigen::Vector4d> on_its_way_;
};

struct Flown {
  double worst_position = 0.0, worst_attitude_deg = 0.0, peak_rate_deg = 0.0, end_position = 0.0;
  Vec3d end_axis;
};

/// `plan(t_ms)` fills in what the ground knows of the future; the vehicle starts at `start`.
template <class Plan>
Flown fly(const Vehicle& vehicle, const Params& params, const Plan& plan, int until_ms, const Vec3d& start) {
  Body body(vehicle);
  body.p = start;
  OuterLoop outer_loop(vehicle);
  RotorLagInverse lag_inverse;
  std::deque<Estimate> past;
  std::deque<std::pair<int, Setpoint>> link;
  Setpoint setpoint;
  setpoint.thrust = static_cast<float>(vehicle.mass * oracle::kGravity);
  Flown flown;
  for (int k = 0; k < until_ms; ++k) {
    Estimate now;
    now.q_WB = oracle::to_core(body.q);
    now.w_WB_B = body.w.cast<float>();
    now.p_WB = body.p.cast<float>();
    now.v_WB = body.v.cast<float>();
    past.push_back(now);
    if (past.size() > kStateAge + 1) past.pop_front();
    OuterLoopInput in = plan(k);
    if (k % 10 == 0) {
      in.t_us = static_cast<std::uint64_t>(k) * 1000;
      in.state = past.front();
      in.mid_age = static_cast<float>(kMidAge);
      link.emplace_back(k + kLinkDelay, outer_loop.step(in, params));
    }
    if (!link.empty() && link.front().first <= k) {
      setpoint = link.front().second;
      link.pop_front();
    }
    const Reference reference = extrapolate(setpoint, now, static_cast<std::uint64_t>(k) * 1000, params);
    const Wrench wanted = attitude_wrench(now.q_WB, now.w_WB_B, reference, vehicle, params);
    body.step(lag_inverse.step(allocate(wanted, vehicle).rotors, vehicle, params));
    flown.worst_position = std::max(flown.worst_position, (now.p_WB - in.now.position).cast<double>().norm());
    flown.worst_attitude_deg =
        std::max(flown.worst_attitude_deg, oracle::angle_between(now.q_WB, reference.q_WD) / oracle::kDegree);
    flown.peak_rate_deg = std::max(flown.peak_rate_deg, body.w.norm() / oracle::kDegree);
    flown.end_position = (now.p_WB - in.now.position).cast<double>().norm();
  }
  flown.end_axis = body.q * Vec3d::UnitZ();
  return flown;
}

FlatReference at(const oracle::FreeFallFlip& flip, double t) {
  FlatReference r;
  r.position = flip.at(t, 0).cast<float>();
  r.velocity = flip.at(t, 1).cast<float>();
  r.acceleration = flip.at(t, 2).cast<float>();
  r.jerk = flip.at(t, 3).cast<float>();
  r.snap = flip.at(t, 4).cast<float>();
  return r;
}

}  // namespace

TEST_CASE("the free-fall flip is flown within 5 mm and 6 deg, and ends in inverted hover") {
  const oracle::FreeFallFlip flip;
  const Params params;
  const double rate_lead = 1.0 / (2.0 * params.att_damping * params.att_natural_frequency) + kMidAge;
  const auto plan = [&](int k) {
    const double t = k * kStep;
    OuterLoopInput in;
    in.now = at(flip, t);
    in.at_sample = at(flip, std::max(0.0, t - kStateAge * kStep));
    in.lead_acceleration = flip.at(t + params.actuator_lead + kMidAge, 2).cast<float>();
    in.lead_rate = {0.F, static_cast<float>(flip.rate(t + rate_lead) - flip.rate(t)), 0.F};
    in.sigma = t < oracle::FreeFallFlip::kHalf ? 1.F : -1.F;
    in.sigma_event_near = std::abs(t - oracle::FreeFallFlip::kHalf) < 0.06;
    return in;
  };
  const Flown flown = fly(oracle::paper_vehicle(), params, plan, 2500, Vec3d::Zero());
  MESSAGE("worst " << flown.worst_position * 1e3 << " mm, " << flown.worst_attitude_deg << " deg, peak "
                   << flown.peak_rate_deg << " deg/s");
  CHECK(flown.worst_position < 5e-3);
  CHECK(flown.worst_attitude_deg < 6.0);
  CHECK(flown.peak_rate_deg > 880.0);
  CHECK(flown.peak_rate_deg < 980.0);
  CHECK(flown.end_axis.z() < -0.9999);
}

TEST_CASE("both vehicles come back from a metre away and stand still") {
  const auto hover = [](int) { return OuterLoopInput{}; };
  Params params;
  const Flown variable = fly(oracle::paper_vehicle(), params, hover, 12000, {0.6, -0.6, 0.5});
  MESSAGE("variable pitch: left " << variable.end_position * 1e3 << " mm");
  CHECK(variable.end_position < 0.05);

  params.att_natural_frequency = 10.F;
  params.att_damping = 1.F;
  params.pos_kp_xy = 4.F;
  params.pos_kd_xy = 3.4F;
  params.pos_ki_xy = 0.5F;
  params.actuator_lead = 0.04F;
  const Flown fixed = fly(oracle::fixed_pitch_vehicle(), params, hover, 12000, {0.6, -0.6, 0.5});
  MESSAGE("fixed pitch: left " << fixed.end_position * 1e3 << " mm");
  CHECK(fixed.end_position < 0.05);
  CHECK(fixed.end_axis.z() > 0.99);
}

}  // namespace halfroll
