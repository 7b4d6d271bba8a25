// The outer loop against finite differences and against the paper's free-fall flip. Why: a wrong rate term flies,
// badly.
#include "core/outer_loop.hpp"

#include <doctest/doctest.h>

#include "core/constants.hpp"
#include "core/quaternion.hpp"
#include "free_fall_flip.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::Quatd;
using oracle::Random;
using oracle::Vec3d;

/// A smooth force with two derivatives, tilting over most of the upper (lift > 0) or lower half space.
struct SmoothForce {
  double lift;
  Vec3d operator()(double t, int order) const {
    const auto wave = [&](double a, double w, double phase) {
      return a * std::pow(w, order) * std::cos(w * t + phase + order * oracle::kDegree * 90.0);
    };
    return {wave(3.0, 1.7, 0.3) + wave(1.0, 3.1, 2.0), wave(2.5, 2.3, 1.1),
            (order == 0 ? 4.0 * lift : 0.0) + wave(1.5, 2.9, 0.5)};
  }
};

double yaw(double t, int order) {
  return 0.8 * std::pow(1.7, order) * std::sin(1.7 * t + order * oracle::kDegree * 90.0);
}

/// Closed form of the core and finite differences of an attitude that Eigen builds, in one chart.
void compare_chart(const SmoothForce& force, const Quatd& half_turn, float gamma) {
  const bool inverted = force.lift < 0.0;
  const auto attitude = [&](double t) {
    const Vec3d n = force(t, 0).normalized();
    const Quatd least = Quatd::FromTwoVectors(Vec3d::UnitZ(), half_turn.conjugate() * n);
    return Quatd(half_turn * least * oracle::turn({0.0, 0.0, yaw(t, 0)}));
  };
  for (double t = 0.0; t < 4.0; t += 0.037) {
    const ThrustAxis axis =
        unit_derivatives(force(t, 0).cast<float>(), force(t, 1).cast<float>(), force(t, 2).cast<float>());
    const ForceAttitude levelled =
        inverted ? least_rotation_inverted(axis.n, axis.n1, axis.n2, gamma) : least_rotation(axis.n, axis.n1, axis.n2);
    const ForceAttitude got =
        with_yaw(levelled, static_cast<float>(yaw(t, 0)), static_cast<float>(yaw(t, 1)), static_cast<float>(yaw(t, 2)));
    const Vec3d w = oracle::body_rate(attitude, t);
    const Vec3d dw = (oracle::body_rate(attitude, t + 1e-4) - oracle::body_rate(attitude, t - 1e-4)) / 2e-4;
    CHECK(oracle::angle_between(oracle::from_core(got.q_WD), attitude(t)) < 1e-5);
    CHECK((got.w_WD_D.cast<double>() - w).norm() < 2e-5 * (1.0 + w.norm()));
    CHECK((got.dw_WD_D.cast<double>() - dw).norm() < 1e-4 * (1.0 + dw.norm()));
  }
}

Vec3 core(const Vec3d& v) { return v.cast<float>(); }

Params without_feedback() {
  Params p;
  p.pos_kp_xy = p.pos_kp_z = p.pos_ki_xy = p.pos_ki_z = p.pos_kd_xy = p.pos_kd_z = 0.F;
  return p;
}

OuterLoopInput on_plan(const Vec3& acceleration, const Vec3& jerk = Vec3::Zero(), const Vec3& snap = Vec3::Zero()) {
  OuterLoopInput in;
  in.now.acceleration = in.at_sample.acceleration = in.lead_acceleration = acceleration;
  in.now.jerk = jerk;
  in.now.snap = snap;
  return in;
}

OuterLoopInput on_plan(const oracle::FreeFallFlip& flip, double t) {
  OuterLoopInput in = on_plan(core(flip.at(t, 2)), core(flip.at(t, 3)), core(flip.at(t, 4)));
  in.sigma = t < oracle::FreeFallFlip::kHalf ? 1.F : -1.F;
  in.sigma_event_near = std::abs(t - oracle::FreeFallFlip::kHalf) < 0.06;
  return in;
}

OuterLoopInput hovering() { return on_plan(Vec3::Zero()); }

}  // namespace

TEST_CASE("rates and angular accelerations of chart A with yaw are those of finite differences") {
  compare_chart({1.0}, Quatd::Identity(), 0.F);
}

TEST_CASE("rates and angular accelerations of chart C with yaw are those of finite differences") {
  for (const float gamma : {0.F, 0.7F, -2.5F}) {
    compare_chart({-1.0}, Quatd(0.0, std::cos(gamma), std::sin(gamma), 0.0), gamma);
  }
}

TEST_CASE("attitude stays continuous through both charts on a path that is not planar") {
  OuterLoop loop(oracle::paper_vehicle());
  Params params = without_feedback();
  params.fade_force = 0.F;
  params.sign_rule = 2.F;
  Quat before;
  bool was_inverted = false;
  int changes = 0;
  for (int k = 0; k < 2000; ++k) {  // the thrust axis winds from pole to pole while its heading drifts
    const double t = k * 0.01;
    const double tilt = 1.4 * t, heading = 0.35 * t;
    const Vec3d n(std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), std::cos(tilt));
    OuterLoopInput in = on_plan(core(8.0 * n) - Vec3(0.F, 0.F, kGravity));
    in.now.yaw = static_cast<float>(0.3 * t);
    const Setpoint s = loop.step(in, params);
    if (k > 0) REQUIRE(oracle::angle_between(before, s.q_WD) < 0.05);
    CHECK((up_axis(s.q_WD).cast<double>() - n).norm() < 1e-5);
    before = s.q_WD;
    changes += was_inverted != (n.z() < 0.0);
    was_inverted = n.z() < 0.0;
  }
  CHECK(changes > 6);
}

TEST_CASE("the free-fall flip turns over smoothly with the paper's peak rate, at any phase of the ticks") {
  const oracle::FreeFallFlip flip;
  double peak = 0.0;
  for (int phase = 0; phase < 10; ++phase) {
    OuterLoop loop(oracle::paper_vehicle());
    Quat before;
    for (int k = 0; k <= 108; ++k) {
      const double t = k * 0.01 + phase * 1e-3;
      const Setpoint s = loop.step(on_plan(flip, t), without_feedback());
      const Vec3d n = flip.force(t).normalized() * (t < oracle::FreeFallFlip::kHalf ? 1.0 : -1.0);
      const bool held = 0.571 * flip.force(t).norm() < 0.1;
      REQUIRE(std::acos(std::min(1.0, n.dot(up_axis(s.q_WD).cast<double>()))) < (held ? 0.03 : 2e-3));
      if (k > 0)
        REQUIRE(oracle::angle_between(before, s.q_WD) < 0.18);  // 10 ms at 956 deg/s, and what the hold was off
      REQUIRE(dot(before, s.q_WD) > 0.F);
      before = s.q_WD;
      peak = std::max(peak, static_cast<double>(s.w_WD_D.norm()) / oracle::kDegree);
    }
    CHECK(up_axis(before).z() == doctest::Approx(-1.0));
  }
  MESSAGE("peak commanded rate " << peak << " deg/s");
  CHECK(peak > 944.7 * 0.99);
  CHECK(peak < 956.3 * 1.01);
}

TEST_CASE("where feedback moves a reversal away from its event, the paper's rule jumps and continuity does not") {
  for (const float rule : {0.F, 1.F, 2.F}) {
    OuterLoop loop(oracle::paper_vehicle());
    Params params;
    params.sign_rule = rule;
    double step = 0.0;
    Quat before;
    for (int k = 16; k <= 46; ++k) {  // from upright to inverted at 10 rad/s, never near zero force
      const double t = k * 0.01, event = 0.305, angle = 10.0 * (t - event) + 90.0 * oracle::kDegree;
      OuterLoopInput in = on_plan(core(7.0 * Vec3d(std::sin(angle), 0.0, std::cos(angle))) - Vec3(0.F, 0.F, kGravity));
      in.sigma = t < event ? 1.F : -1.F;
      in.sigma_event_near = std::abs(t - event) < 0.06;
      in.state.p_WB = Vec3(0.F, 0.F, 0.1F);  // too high: the vertical force reverses early
      const Setpoint s = loop.step(in, params);
      if (k > 16) step = std::max(step, oracle::angle_between(before, s.q_WD) / oracle::kDegree);
      before = s.q_WD;
    }
    CAPTURE(rule);
    if (rule == 1.F) CHECK(step > 170.0);
    if (rule != 1.F) CHECK(step < 10.0);
  }
}

TEST_CASE("while the body is more than a right angle off, feedback does not turn its reference; close to it, it does") {
  const auto turning_at = [](double off) {
    OuterLoop loop(oracle::paper_vehicle());
    OuterLoopInput in = hovering();
    in.state.q_WB = oracle::to_core(oracle::turn({0.0, off * oracle::kDegree, 0.0}));
    return loop.step(in, Params{}).w_WD_D.norm();
  };
  for (const double off : {91.0, 120.0, 179.0, -100.0}) CHECK(turning_at(off) == 0.F);
  CHECK(turning_at(30.0) > 1.F);
  CHECK(turning_at(80.0) < turning_at(45.0));
}

TEST_CASE("hover asks for the weight upright, and for minus the weight upside down") {
  const Vehicle vehicle = oracle::paper_vehicle();
  OuterLoop upright(vehicle), inverted(vehicle);
  OuterLoopInput in = hovering();
  CHECK(upright.step(in, Params{}).thrust == doctest::Approx(0.571F * kGravity));

  const Quat upside_down{0.F, 1.F, 0.F, 0.F};
  inverted.reset(upside_down);
  in.sigma = -1.F;
  in.state.q_WB = upside_down;
  const Setpoint s = inverted.step(in, Params{});
  CHECK(s.thrust == doctest::Approx(-0.571F * kGravity));
  CHECK(oracle::angle_between(s.q_WD, upside_down) < 1e-4);
}

TEST_CASE("after a reset the loop continues from the attitude it was given, whatever that is") {
  Random random(5);
  for (int i = 0; i < 300; ++i) {
    const Quatd q = i == 0 ? Quatd(0.0, std::cos(0.4), std::sin(0.4), 0.0) : random.attitude();
    const Vec3d n = q * Vec3d::UnitZ();
    OuterLoop loop(oracle::paper_vehicle());
    loop.reset(oracle::to_core(q));
    OuterLoopInput in = on_plan(core(8.0 * n) - Vec3(0.F, 0.F, kGravity));
    in.sigma = n.z() < 0.0 ? -1.F : 1.F;
    if (n.z() < 0.0) in.now.acceleration = in.lead_acceleration = core(-8.0 * n) - Vec3(0.F, 0.F, kGravity);
    in.now.yaw = heading_after_levelling(oracle::to_core(q));
    if (std::abs(n.z()) > 0.06) {
      CHECK(oracle::angle_between(loop.step(in, without_feedback()).q_WD, oracle::to_core(q)) < 2e-3);
    }
  }
}

TEST_CASE("position errors push back and the integral is clamped, frozen on the ground and at full thrust") {
  const Vehicle vehicle = oracle::paper_vehicle();
  OuterLoopInput low = hovering();
  low.state.p_WB = {0.F, 0.F, -0.1F};
  const auto thrust_after = [&](OuterLoopInput in, int ticks) {
    OuterLoop loop(vehicle);
    for (int k = 0; k < ticks; ++k) loop.step(in, Params{});
    return loop.step(in, Params{}).thrust;
  };
  const double weight = 0.571 * 9.81;
  CHECK(thrust_after(low, 0) == doctest::Approx(weight + 0.571 * (1.2 + 0.001)).epsilon(1e-5));
  CHECK(thrust_after(low, 99) == doctest::Approx(weight + 0.571 * (1.2 + 0.1)).epsilon(1e-5));
  CHECK(thrust_after(low, 2000) == doctest::Approx(weight + 0.571 * (1.2 + 1.0)).epsilon(1e-5));
  low.on_ground = true;
  CHECK(thrust_after(low, 2000) == doctest::Approx(weight + 0.571 * 1.2).epsilon(1e-5));

  OuterLoopInput far = hovering();
  far.state.p_WB = {0.F, 0.F, -5.F};
  OuterLoop loop(vehicle);
  for (int k = 0; k < 200; ++k) loop.step(far, Params{});
  const float frozen = loop.step(hovering(), Params{}).thrust;
  CHECK(frozen == doctest::Approx(weight + 0.571 * 0.05).epsilon(1e-4));
}

TEST_CASE("a fixed-pitch vehicle is never asked to point its force below half its weight") {
  OuterLoop loop(oracle::fixed_pitch_vehicle());
  OuterLoopInput in = hovering();
  in.state.p_WB = {3.F, 0.F, 5.F};
  in.sigma = -1.F;
  in.now.jerk = {0.F, 0.F, -100.F};
  for (int k = 0; k < 50; ++k) {
    const Setpoint s = loop.step(in, Params{});
    CHECK(up_axis(s.q_WD).z() > 0.F);
    CHECK(s.w_WD_D.y() == doctest::Approx(s.w_WD_D.y()));
  }
}

TEST_CASE(
    "drag is leant against: in steady flight the force balances weight and drag, without any error to feed back") {
  const Vehicle vehicle = oracle::paper_vehicle();
  OuterLoop loop(vehicle);
  Params params = without_feedback();
  params.drag = 0.05F;
  OuterLoopInput in = hovering();
  in.now.velocity = in.at_sample.velocity = in.state.v_WB = {10.F, 0.F, 0.F};
  const Setpoint s = loop.step(in, params);
  const Vec3 force = s.thrust * up_axis(s.q_WD);
  CHECK(force.x() == doctest::Approx(0.5F));
  CHECK(force.z() == doctest::Approx(0.571F * kGravity));
}

TEST_CASE("led rates are added, and what they turn on average is taken back from the attitude") {
  OuterLoop plain(oracle::paper_vehicle()), led(oracle::paper_vehicle());
  OuterLoopInput in = hovering();
  const Setpoint before = plain.step(in, Params{});
  in.lead_rate = {0.F, 2.F, 0.F};
  in.mid_age = 0.007F;
  const Setpoint s = led.step(in, Params{});
  CHECK(s.w_WD_D.isApprox(before.w_WD_D + in.lead_rate));
  const Quatd extrapolated = oracle::from_core(s.q_WD) * oracle::turn({0.0, 2.0 * 0.007, 0.0});
  CHECK(oracle::angle_between(extrapolated, oracle::from_core(before.q_WD)) < 1e-5);
}

TEST_CASE("a state and its attitude's negative give the same setpoint") {
  OuterLoop a(oracle::paper_vehicle()), b(oracle::paper_vehicle());
  OuterLoopInput in = hovering();
  in.state.q_WB = oracle::to_core(Random(3).attitude());
  const Setpoint s = a.step(in, Params{});
  in.state.q_WB = -in.state.q_WB;
  const Setpoint negated = b.step(in, Params{});
  CHECK(s.q_WD == negated.q_WD);
  CHECK(s.w_WD_D == negated.w_WD_D);
  CHECK(a.state() == b.state());
}

TEST_CASE("nothing that is not finite gets through, and the loop goes on after it") {
  for (const float bad : {NAN, INFINITY, -INFINITY, 3e38F}) {
    for (int field = 0; field < 12; ++field) {
      OuterLoop loop(oracle::paper_vehicle());
      OuterLoopInput in = hovering();
      loop.step(in, Params{});
      Vec3* vectors[] = {&in.state.p_WB,
                         &in.state.v_WB,
                         &in.at_sample.position,
                         &in.at_sample.velocity,
                         &in.at_sample.acceleration,
                         &in.now.acceleration,
                         &in.now.jerk,
                         &in.now.snap,
                         &in.lead_acceleration,
                         &in.lead_rate};
      if (field < 10) (*vectors[field])[field % 3] = bad;
      if (field == 10) in.state.q_WB.y = bad;
      if (field == 11) in.now.yaw_rate = bad;
      const Setpoint s = loop.step(in, Params{});
      CAPTURE(field);
      CAPTURE(bad);
      CHECK(is_finite(s.q_WD));
      CHECK(dot(s.q_WD, s.q_WD) == doctest::Approx(1.0));
      CHECK(s.w_WD_D.allFinite());
      CHECK(std::isfinite(s.thrust));
      const Setpoint after = loop.step(hovering(), Params{});
      CHECK(is_finite(after.q_WD));
      CHECK(std::isfinite(after.thrust));
    }
  }
}

}  // namespace halfroll
