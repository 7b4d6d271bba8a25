// The estimator on motions that are known exactly. Why: delayed poses must cost noise, never lag or stability.
#include "core/estimator.hpp"

#include <doctest/doctest.h>

#include <vector>

#include "core/quaternion.hpp"
#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::Quatd;
using oracle::Random;
using oracle::Vec3d;

/// Truth: position as a function of time, and attitude.
struct Trajectory {
  Vec3d (*position)(double t);
  Quatd (*attitude)(double t);
  Vec3d velocity(double t) const { return (position(t + 1e-4) - position(t - 1e-4)) / 2e-4; }
  Vec3d acceleration(double t) const { return (position(t + 1e-3) - 2.0 * position(t) + position(t - 1e-3)) / 1e-6; }
};

Quatd level(double) { return Quatd::Identity(); }
Vec3d standing(double) { return {1.0, -2.0, 3.0}; }
Vec3d weaving(double t) {
  return {0.75 * std::sin(2.0 * t), 0.5 * std::cos(2.0 * t), 1.0 + 0.2 * std::sin(t)};
}  // 3 m/s²
Quatd leaning(double t) {
  const Trajectory self{weaving, level};
  return Quatd::FromTwoVectors(Vec3d::UnitZ(), self.acceleration(t) + Vec3d(0.0, 0.0, oracle::kGravity));
}
Vec3d falling(double t) { return {2.0 * t, 0.0, 20.0 + 3.0 * t - 0.5 * oracle::kGravity * t * t}; }
Quatd tumbling(double t) { return Quatd(0.0, 0.6, 0.8, 0.0) * oracle::turn(Vec3d(3.0, -9.0, 2.0) * t); }

constexpr Trajectory kHover{standing, level}, kManoeuvre{weaving, leaning}, kTumble{falling, tumbling};

struct Sensors {
  int pose_every_ms = 10, pose_delay_ms = 10;
  double gyro = 0.0, accelerometer = 0.0, position = 0.0, attitude = 0.0;  // standard deviations
  Vec3d gyro_bias = Vec3d::Zero();
  std::uint64_t pose_phase_us = 0;
};
Sensors nominal() {
  Sensors s;
  s.gyro = 0.01;
  s.accelerometer = 0.1;
  s.position = 1e-3;
  s.attitude = 0.2 * oracle::kDegree;
  return s;
}

Measurements measured(const Imu& imu, const std::optional<PoseFix>& pose) {
  Measurements m;
  m.imu = imu;
  m.pose = pose;
  return m;
}

struct Errors {
  double position = 0.0, velocity = 0.0, attitude_deg = 0.0;  // root mean square of the size
  double worst_position = 0.0, worst_velocity = 0.0, worst_attitude_deg = 0.0;
};

Errors errors_of(const Trajectory& motion, const Sensors& sensors, double from_s, double until_s, unsigned seed = 1) {
  Random random(seed);
  Estimator estimator;
  Errors sum;
  int count = 0;
  for (int k = 0; k * 1e-3 < until_s; ++k) {
    const double t = k * 1e-3;
    const Quatd q = motion.attitude(t);
    Imu imu;
    imu.w_WB_B =
        (oracle::body_rate(motion.attitude, t) + sensors.gyro_bias + random.normal3(sensors.gyro)).cast<float>();
    imu.specific_force_B = (q.conjugate() * (motion.acceleration(t) + Vec3d(0.0, 0.0, oracle::kGravity)) +
                            random.normal3(sensors.accelerometer))
                               .cast<float>();
    std::optional<PoseFix> pose;
    const int taken = k - sensors.pose_delay_ms;
    if (taken >= 0 && taken % sensors.pose_every_ms == 0) {
      pose = PoseFix{};
      pose->t_us = static_cast<std::uint64_t>(taken) * 1000 + sensors.pose_phase_us;
      const double then = static_cast<double>(pose->t_us) * 1e-6;
      pose->p_WB = (motion.position(then) + random.normal3(sensors.position)).cast<float>();
      pose->q_WB = oracle::to_core(motion.attitude(then) * oracle::turn(random.normal3(sensors.attitude)));
    }
    const Estimate e = estimator.step(static_cast<std::uint64_t>(k) * 1000, measured(imu, pose), true, Params{});
    if (t < from_s) continue;
    const double p = (e.p_WB.cast<double>() - motion.position(t)).norm();
    const double v = (e.v_WB.cast<double>() - motion.velocity(t)).norm();
    const double a = oracle::angle_between(oracle::from_core(e.q_WB), q) / oracle::kDegree;
    sum.position += p * p;
    sum.velocity += v * v;
    sum.attitude_deg += a * a;
    sum.worst_position = std::max(sum.worst_position, p);
    sum.worst_velocity = std::max(sum.worst_velocity, v);
    sum.worst_attitude_deg = std::max(sum.worst_attitude_deg, a);
    ++count;
  }
  sum.position = std::sqrt(sum.position / count);
  sum.velocity = std::sqrt(sum.velocity / count);
  sum.attitude_deg = std::sqrt(sum.attitude_deg / count);
  return sum;
}

PoseFix pose_at(std::uint64_t t_us, const Vec3& p = Vec3::Zero()) {
  PoseFix pose;
  pose.t_us = t_us;
  pose.p_WB = p;
  return pose;
}
const Imu kResting{Vec3::Zero(), Vec3(0.F, 0.F, 9.81F)};

}  // namespace

TEST_CASE("with nominal noise the estimate is within 2 mm, 0.03 m/s and 0.3 deg in hover and in a manoeuvre") {
  for (const Trajectory& motion : {kHover, kManoeuvre}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const Errors e = errors_of(motion, nominal(), 1.0, 6.0, seed);
      MESSAGE("rms " << e.position * 1e3 << " mm, " << e.velocity << " m/s, " << e.attitude_deg << " deg");
      CHECK(e.position < 2e-3);
      CHECK(e.velocity < 0.03);
      CHECK(e.attitude_deg < 0.3);
    }
  }
}

TEST_CASE("with perfect sensors it is exact, at any pose rate and delay, also tumbling in free fall") {
  for (const Trajectory& motion : {kHover, kManoeuvre, kTumble}) {
    for (const int every : {1, 10, 37, 100}) {
      for (const int delay : {0, 10, 60}) {
        Sensors perfect;
        perfect.pose_every_ms = every;
        perfect.pose_delay_ms = delay;
        const Errors e = errors_of(motion, perfect, 0.6, 1.6);
        CAPTURE(every);
        CAPTURE(delay);
        CHECK(e.worst_position < 1e-4);
        CHECK(e.worst_velocity < 1e-3);
        CHECK(e.worst_attitude_deg < 0.01);
      }
    }
  }
}

TEST_CASE("a pose taken between two milliseconds is compared with that instant") {
  Sensors between;
  between.pose_phase_us = 500;
  between.pose_delay_ms = 10;
  CHECK(errors_of(kTumble, between, 0.6, 1.6).worst_position < 1e-4);
  CHECK(errors_of(kTumble, between, 0.6, 1.6).worst_attitude_deg < 0.05);
}

TEST_CASE("a tumbling vehicle is placed by its first poses: exact after a tenth of a second") {
  const Errors e = errors_of(kTumble, Sensors{}, 0.15, 0.5);
  CHECK(e.worst_position < 1e-3);
  CHECK(e.worst_velocity < 0.01);
  CHECK(e.worst_attitude_deg < 0.1);
}

TEST_CASE("a gyro bias is learnt") {
  Sensors biased;
  biased.gyro_bias = {0.05, -0.03, 0.02};
  const Errors early = errors_of(kHover, biased, 0.3, 0.6), late = errors_of(kHover, biased, 25.0, 30.0);
  CHECK(late.attitude_deg < 0.05);
  CHECK(late.attitude_deg < 0.3 * early.attitude_deg);
}

TEST_CASE(
    "the position becomes valid after 0.1 s of poses and invalid after 0.5 s without; the attitude lasts longer") {
  Estimator estimator;
  bool valid_at[2000] = {};
  for (std::uint64_t k = 0; k < 2000; ++k) {
    std::optional<PoseFix> pose;
    if (k % 10 == 0 && (k < 500 || k >= 1500)) pose = pose_at(k * 1000);
    const Estimate e = estimator.step(k * 1000, measured(kResting, pose), false, Params{});
    CHECK(e.attitude_valid == (k >= 100));
    valid_at[k] = e.position_valid;
  }
  CHECK(!valid_at[99]);
  CHECK(valid_at[100]);
  CHECK(valid_at[989]);
  CHECK(!valid_at[991]);
  CHECK(!valid_at[1600]);  // the first pose of the second row was taken in at 1501
  CHECK(valid_at[1601]);
}

TEST_CASE("poses and samples that make no sense change nothing") {
  PoseFix bad[5] = {pose_at(0), pose_at(0), pose_at(0), pose_at(0), pose_at(0)};
  bad[0].p_WB.y() = NAN;
  bad[1].q_WB.x = INFINITY;
  bad[2].q_WB = {0.F, 0.F, 0.F, 0.F};
  bad[3].q_WB.w = 1.5F;
  bad[4].p_WB = {9.F, 9.F, 9.F};
  for (int i = 0; i < 5; ++i) {
    Estimator with, without;
    for (std::uint64_t k = 0; k < 200; ++k) {
      std::optional<PoseFix> pose;
      if (k % 10 == 0) pose = pose_at(k * 1000, Vec3(1.F, 2.F, 3.F));
      std::optional<PoseFix> other = pose;
      if (k == 155) {
        other = bad[i];
        other->t_us = i == 4 ? 20000 : 154000;  // the last one is older than the latest used
      }
      with.step(k * 1000, measured(kResting, other), false, Params{});
      without.step(k * 1000, measured(kResting, pose), false, Params{});
    }
    CAPTURE(i);
    CHECK(with.state() == without.state());
  }
}

TEST_CASE("an inertial sample that is not finite never reaches the estimate") {
  Estimator estimator;
  for (std::uint64_t k = 0; k < 300; ++k) {
    Imu imu = kResting;
    if (k % 7 == 3) imu.w_WB_B.x() = NAN;
    if (k % 7 == 5) imu.specific_force_B.z() = INFINITY;
    std::optional<PoseFix> pose;
    if (k % 10 == 0) pose = pose_at(k * 1000);
    const Estimate e = estimator.step(k * 1000, measured(imu, pose), false, Params{});
    REQUIRE(is_finite(e.q_WB));
    REQUIRE(e.w_WB_B.allFinite());
    REQUIRE(e.p_WB.norm() < 1e-3F);
    REQUIRE(e.v_WB.norm() < 1e-2F);
  }
}

}  // namespace halfroll
