// The attitude law on a rigid body in double. Why: one sign in Eq 22 decides between turning home and turning away.
#include "core/attitude.hpp"

#include <doctest/doctest.h>

#include "core/quaternion.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::Quatd;
using oracle::Random;
using oracle::Vec3d;

constexpr double kStep = 1e-3;

/// A target that turns about changing axes: up to 3 rad/s.
Vec3d target_rate(double t) {
  return {1.5 * std::sin(1.3 * t), 2.0 * std::cos(0.9 * t), 1.2 * std::sin(0.7 * t + 1.0)};
}
Vec3d target_acceleration(double t) {
  return {1.95 * std::cos(1.3 * t), -1.8 * std::sin(0.9 * t), 0.84 * std::cos(0.7 * t + 1.0)};
}

struct Outcome {
  double settled_s = 0.0;  // last time beyond 2 deg
  double error = 0.0;      // at the end [rad]
};

/// Torque straight on the body for two seconds, limited to `torque_max`.
Outcome turn_home(double initial_error, const Vec3d& w_WB_B, const Params& params, Random& random, Vec3d torque_max,
                  double target_motion = 1.0) {
  const Vehicle vehicle = oracle::paper_vehicle();
  const Vec3d inertia = vehicle.inertia.cast<double>();
  Quatd q_WD = random.attitude();
  Quatd q_WB = q_WD * oracle::turn(initial_error * random.normal3(1.0).normalized());
  if (random.uniform(0.0, 1.0) < 0.5) q_WB = Quatd(-q_WB.w(), -q_WB.x(), -q_WB.y(), -q_WB.z());
  Vec3d w = w_WB_B;
  Outcome outcome;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * kStep;
    Reference reference;
    reference.q_WD = oracle::to_core(q_WD);
    reference.w_WD_D = (target_motion * target_rate(t)).cast<float>();
    reference.dw_WD_D = (target_motion * target_acceleration(t)).cast<float>();
    const Vec3d torque =
        attitude_wrench(oracle::to_core(q_WB), w.cast<float>(), reference, vehicle, params).torque.cast<double>();
    const Vec3d given = torque.cwiseMax(-torque_max).cwiseMin(torque_max);
    const Vec3d dw = (given - w.cross(inertia.cwiseProduct(w))).cwiseQuotient(inertia);
    q_WB = (q_WB * oracle::turn((w + 0.5 * kStep * dw) * kStep)).normalized();
    w += kStep * dw;
    q_WD = (q_WD * oracle::turn(target_motion * target_rate(t + 0.5 * kStep) * kStep)).normalized();
    outcome.error = oracle::angle_between(q_WB, q_WD);
    if (outcome.error > 2.0 * oracle::kDegree) outcome.settled_s = t;
  }
  return outcome;
}

const Vec3d kUnlimited = Vec3d::Constant(1e9);

}  // namespace

TEST_CASE("the body turns onto a moving reference from any attitude within 0.4 s") {
  Random random(1);
  double slowest = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double error = i < 100 ? 1.799 * i : random.uniform(179.0, 179.9);
    const Outcome o = turn_home(error * oracle::kDegree, target_rate(0.0), Params{}, random, kUnlimited);
    slowest = std::max(slowest, o.settled_s);
    CHECK(o.error < 0.1 * oracle::kDegree);
  }
  MESSAGE("slowest settling to 2 deg " << slowest << " s");
  CHECK(slowest < 0.4);
}

TEST_CASE("it also gets there while tumbling, and with the rotors' limited torque") {
  Random random(2);
  for (int i = 0; i < 60; ++i) {
    const double error = random.uniform(0.0, 179.9) * oracle::kDegree;
    CHECK(turn_home(error, random.normal3(5.0), Params{}, random, kUnlimited).error < 0.1 * oracle::kDegree);
    CHECK(turn_home(error, Vec3d::Zero(), Params{}, random, {1.05, 1.05, 0.12}).error < 1.0 * oracle::kDegree);
  }
}

TEST_CASE("the law as printed turns away: it ends upside down to its reference") {
  Random random(3);
  Params params;
  params.attitude_law = 1.F;
  for (int i = 0; i < 20; ++i) {
    const double error = random.uniform(5.0, 170.0) * oracle::kDegree;
    CHECK(turn_home(error, Vec3d::Zero(), params, random, kUnlimited, 0.0).error > 178.0 * oracle::kDegree);
  }
}

TEST_CASE("q and -q give the same torque") {
  Random random(4);
  for (int i = 0; i < 100; ++i) {
    const Quat q = oracle::to_core(random.attitude());
    const Vec3 w = random.normal3(5.0).cast<float>();
    Reference reference;
    reference.q_WD = oracle::to_core(random.attitude());
    reference.w_WD_D = random.normal3(5.0).cast<float>();
    const Vec3 torque = attitude_wrench(q, w, reference, oracle::paper_vehicle(), Params{}).torque;
    CHECK(attitude_wrench(-q, w, reference, oracle::paper_vehicle(), Params{}).torque == torque);
    reference.q_WD = -reference.q_WD;
    CHECK(attitude_wrench(q, w, reference, oracle::paper_vehicle(), Params{}).torque == torque);
  }
}

TEST_CASE("exactly upside down to its reference, the body still turns") {
  Reference reference;
  reference.q_WD = {0.F, 1.F, 0.F, 0.F};
  CHECK(attitude_wrench(Quat{}, Vec3::Zero(), reference, oracle::paper_vehicle(), Params{}).torque.norm() > 0.1F);
}

TEST_CASE("small errors answer with the natural frequency and damping of the parameters") {
  const Vehicle vehicle = oracle::paper_vehicle();
  Params params;
  params.att_natural_frequency = 10.F;
  params.att_damping = 0.7F;
  const Vec3 angle(0.01F, -0.02F, 0.015F), w(0.1F, 0.F, -0.2F);
  const Reference level;
  const Vec3 turned = attitude_wrench(from_rotation_vector(angle), Vec3::Zero(), level, vehicle, params).torque;
  CHECK((turned + 100.F * vehicle.inertia.cwiseProduct(angle)).norm() < 1e-3F * turned.norm());
  const Vec3 turning = attitude_wrench(Quat{}, w, level, vehicle, params).torque;
  const Vec3 gyroscopic = w.cross(vehicle.inertia.cwiseProduct(w));
  CHECK((turning - gyroscopic + 14.F * vehicle.inertia.cwiseProduct(w)).norm() < 1e-5F);
}

}  // namespace halfroll
