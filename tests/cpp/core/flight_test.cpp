// The kernels together, over the split: outer loop at 100 Hz with delays, firmware at 1 kHz, rotors with lag, a rigid
// body in double. Why: each term may be right and the loop still wrong; the numbers are those of the reference.
#include <doctest/doctest.h>

#include "core/attitude.hpp"
#include "core/mixer.hpp"
#include "core/outer_loop.hpp"
#include "core/quaternion.hpp"
#include "core/rotor.hpp"
#include "core/setpoint.hpp"
#include "flying_body.hpp"
#include "free_fall_flip.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::kStep;
using oracle::Quatd;
using oracle::Vec3d;

constexpr int kStateAge = 10, kLinkDelay = 2;  // [ms]
constexpr double kMidAge = 0.007;              // link delay and half a period

struct Flown {
  double worst_position = 0.0, worst_attitude_deg = 0.0, peak_rate_deg = 0.0, end_position = 0.0;
  Vec3d end_axis;
};

/// `plan(t_ms)` fills in what the ground knows of the future; the vehicle starts at `start`.
template <class Plan>
Flown fly(const Vehicle& vehicle, const Params& params, const Plan& plan, int until_ms, const Vec3d& start) {
  oracle::FlyingBody body(vehicle);
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

}  // namespace

TEST_CASE("the free-fall flip is flown within 5 mm and 6 deg, and ends in inverted hover") {
  const oracle::FreeFallFlip flip;
  const Params params;
  const double rate_lead = 1.0 / (2.0 * params.att_damping * params.att_natural_frequency) + kMidAge;
  const auto plan = [&](int k) {
    const double t = k * kStep;
    OuterLoopInput in;
    in.now = oracle::reference(flip, t);
    in.at_sample = oracle::reference(flip, std::max(0.0, t - kStateAge * kStep));
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
