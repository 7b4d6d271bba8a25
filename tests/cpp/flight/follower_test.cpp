#include "core/follower.hpp"

#include <doctest/doctest.h>

#include "core/constants.hpp"

using namespace halfroll;

namespace {

struct Extremes {
  float speed = 0.F, acceleration = 0.F, jerk = 0.F, highest = -1e9F, jump = 0.F;
};

Extremes follow(Follower& follower, const FollowerTarget& target, int ticks, const Params& params) {
  Extremes seen;
  for (int i = 0; i < ticks; ++i) {
    const FlatReference before = follower.reference();
    const FlatReference& r = follower.step(target, kReferenceDt, params);
    seen.speed = std::max(seen.speed, r.velocity.head<2>().norm());
    seen.acceleration = std::max(seen.acceleration, r.acceleration.head<2>().norm());
    seen.jerk = std::max(seen.jerk, r.jerk.head<2>().norm());
    seen.highest = std::max(seen.highest, r.position.z());
    seen.jump = std::max(seen.jump, (r.acceleration - before.acceleration).norm());
  }
  return seen;
}

}  // namespace

TEST_CASE("the follower arrives at its target and rests there") {
  const Params params;
  Follower follower;
  follower.start({1.F, -2.F, 3.F}, Vec3::Zero(), 0.F);
  follow(follower, {{40.F, 25.F, 12.F}, 1.F}, 3000, params);
  CHECK((follower.reference().position - Vec3(40.F, 25.F, 12.F)).norm() < 1e-2F);
  CHECK(follower.reference().velocity.norm() < 1e-2F);
  CHECK(follower.reference().yaw == doctest::Approx(1.F).epsilon(1e-3));
}

TEST_CASE("speed, acceleration and jerk of the follower stay inside their limits") {
  const Params params;
  Follower follower;
  follower.start(Vec3::Zero(), {3.F, -2.F, 0.F}, 0.F);
  const Extremes seen = follow(follower, {{-200.F, 80.F, 5.F}, 0.F, 7.F}, 6000, params);
  CHECK(seen.speed < 7.F * 1.01F);
  CHECK(seen.acceleration <= params.acceleration_max * 1.01F);
  CHECK(seen.jerk <= params.jerk_max * 1.001F);
  CHECK(seen.jump <= params.jerk_max * 1.5F * kReferenceDt);
}

TEST_CASE("a climb does not overshoot by more than a hand's breadth") {
  const Params params;
  Follower follower;
  follower.start(Vec3::Zero(), Vec3::Zero(), 0.F);
  CHECK(follow(follower, {{0.F, 0.F, 10.F}, 0.F}, 3000, params).highest < 10.1F);
}

TEST_CASE("the follower turns the short way round") {
  const Params params;
  Follower follower;
  follower.start(Vec3::Zero(), Vec3::Zero(), 3.F);
  follow(follower, {Vec3::Zero(), -3.F}, 5, params);
  CHECK(follower.reference().yaw_rate > 0.F);
}

TEST_CASE("braking from a fast flight stops within the distance its limits allow, without overshoot") {
  const Params params;
  for (const float speed : {1.F, 5.F, 12.F}) {
    Follower follower;
    follower.start(Vec3::Zero(), {0.6F * speed, -0.8F * speed, 0.F}, 0.F);
    float farthest = 0.F;
    while (!follower.at_rest()) {
      const FlatReference& r = follower.brake(kReferenceDt, params);
      CHECK(r.acceleration.norm() <= params.brake_acceleration * 1.001F);
      CHECK(r.jerk.norm() <= params.brake_jerk * 1.001F);
      farthest = std::max(farthest, r.position.norm());
    }
    CHECK(farthest < 0.5F + 0.3F * speed + speed * speed / 12.F);
    CHECK(follower.reference().position.norm() > farthest - 0.02F);
  }
}
