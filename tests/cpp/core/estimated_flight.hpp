// A vehicle that flies by its own estimate: hover, flips through free fall, inverted hover. Why: an estimate is worth
// what the vehicle does with it.
#pragma once
#include "core/attitude.hpp"
#include "core/estimator.hpp"
#include "core/mixer.hpp"
#include "core/outer_loop.hpp"
#include "core/quaternion.hpp"
#include "core/rotor.hpp"
#include "core/setpoint.hpp"
#include "flying_body.hpp"
#include "free_fall_flip.hpp"
#include "sensor_suite.hpp"

namespace oracle {

using Vector15d = Eigen::Matrix<double, 15, 1>;

/// Hover, then a flip every 1.6 s from the first second on: over, back, over, back.
struct Show {
  static constexpr double kFirst = 1.0, kEvery = 1.6;
  FreeFallFlip flip;
  int flips = 0;

  halfroll::OuterLoopInput at(double t) const {
    const int n = std::max(0, std::min(flips - 1, static_cast<int>(std::floor((t - kFirst) / kEvery))));
    const double s = flips == 0 ? -1.0 : t - kFirst - n * kEvery;
    const halfroll::Params params;
    halfroll::OuterLoopInput in;
    in.now = reference(flip, s);
    in.now.position += halfroll::Vec3(static_cast<float>(n * FreeFallFlip::kWidth), 0.F, 2.F);
    in.at_sample = in.now;
    in.lead_acceleration = flip.at(s + params.actuator_lead + 0.005, 2).cast<float>();
    const bool over = s > FreeFallFlip::kHalf;
    in.sigma = (n % 2 == 0) == over && flips > 0 ? -1.F : 1.F;
    if (flips == 0) in.sigma = 1.F;
    in.sigma_event_near = std::abs(s - FreeFallFlip::kHalf) < 0.06;
    if (s > 0.0 && s < FreeFallFlip::kDuration) {
      const double ahead = 1.0 / (2.0 * static_cast<double>(params.att_damping * params.att_natural_frequency)) + 0.005;
      in.lead_rate = {0.F, static_cast<float>(flip.rate(s + ahead) - flip.rate(s)), 0.F};
    }
    in.mid_age = 0.005F;
    return in;
  }
};

/// Firmware kernels and estimator around a flying body.
class Flight {
 public:
  Flight(unsigned seed, int flips) : sensors(seed), body(paper_vehicle()), outer_loop_(vehicle_) {
    show_.flips = flips;
    body.p = {0.0, 0.0, 2.0};
  }

  SensorSuite sensors;
  FlyingBody body;
  halfroll::Estimator estimator;
  halfroll::Estimate estimate;
  int k = 0;
  bool frozen = false;                            // the tracker repeats its last pose with fresh stamps
  halfroll::Vec3 shift = halfroll::Vec3::Zero();  // of the tracker's origin

  void step() {
    halfroll::Measurements m = sensors.read(k, {body.p, body.v, body.w, body.specific_force(), body.q});
    if (m.pose) {
      m.pose->p_WB += shift;
      if (frozen) m.pose->p_WB = last_.p_WB, m.pose->q_WB = last_.q_WB;
      last_ = *m.pose;
    }
    const auto t_us = static_cast<std::uint64_t>(k) * 1000;
    estimate = estimator.step(t_us, m, true, params_);
    if (k % 10 == 0) {
      halfroll::OuterLoopInput in = show_.at(k * kStep);
      in.t_us = t_us;
      in.state = estimate;
      setpoint_ = outer_loop_.step(in, params_);
    }
    const halfroll::Reference wanted_attitude = halfroll::extrapolate(setpoint_, estimate, t_us, params_);
    const halfroll::Wrench wanted =
        halfroll::attitude_wrench(estimate.q_WB, estimate.w_WB_B, wanted_attitude, vehicle_, params_);
    // until it knows where it is, the rotors carry it as they did
    const float hover = 0.25F * vehicle_.mass * halfroll::kGravity;
    if (!estimate.attitude_valid)
      body.step({{hover, hover, hover, hover}});
    else
      body.step(lag_inverse_.step(halfroll::allocate(wanted, vehicle_).rotors, vehicle_, params_));
    ++k;
  }
  void fly(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) step();
  }

  /// Truth minus estimate, of the instant before the last step(). Ask error() before the body moves on: see observe().
  template <class Look>
  void observe(int milliseconds, const Look& look) {
    for (int i = 0; i < milliseconds; ++i) {
      const FlyingBody truth = body;
      step();
      look(error(truth));
    }
  }
  Vector15d error(const FlyingBody& truth) const {
    const Quatd off = truth.q * from_core(estimate.q_WB).conjugate();
    const double sign = off.w() < 0.0 ? -1.0 : 1.0;
    Vector15d e;
    e << 2.0 * std::atan2(off.vec().norm(), sign * off.w()) * sign * off.vec().normalized(),
        truth.v - estimate.v_WB.cast<double>(), truth.p - estimate.p_WB.cast<double>(),
        sensors.true_gyro_bias() - estimator.gyro_bias().cast<double>(),
        sensors.true_accelerometer_bias() - estimator.accelerometer_bias().cast<double>();
    return e;
  }
  double nees(const Vector15d& error) const {
    return error.dot(estimator.covariance().matrix().cast<double>().ldlt().solve(error));
  }

 private:
  halfroll::Params params_;
  halfroll::Vehicle vehicle_ = paper_vehicle();
  Show show_;
  halfroll::OuterLoop outer_loop_;
  halfroll::Setpoint setpoint_;
  halfroll::RotorLagInverse lag_inverse_;
  halfroll::PoseFix last_;
};

}  // namespace oracle
