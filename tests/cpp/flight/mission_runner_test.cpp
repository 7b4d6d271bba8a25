#include "core/mission_runner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/constants.hpp"

using namespace halfroll;

namespace {

struct List final : MissionItems {
  std::vector<FlightItem> items;
  int count() const override { return static_cast<int>(items.size()); }
  int first() const override { return 0; }
  FlightItem item(int seq) const override { return items[static_cast<std::size_t>(seq)]; }
};

FlightItem to(ItemKind kind, const Vec3& position) {
  FlightItem item;
  item.kind = kind;
  item.position = position;
  item.has_position = true;
  return item;
}

FlightItem jump(int seq, int repeats) {
  FlightItem item;
  item.kind = ItemKind::kJump;
  item.jump_to = seq;
  item.repeats = repeats;
  return item;
}

/// A vehicle that is where its reference is.
struct PerfectFlight {
  List items;
  MissionRunner runner;
  Follower follower;
  Params params;
  Estimate estimate;
  std::vector<int> reached;
  bool landed = true;
  bool returned = false;

  explicit PerfectFlight(std::vector<FlightItem> list) {
    items.items = std::move(list);
    runner.reset(0);
    follower.start(Vec3::Zero(), Vec3::Zero(), 0.F);
  }

  /// Seconds until complete, or -1.
  float fly(float longest) {
    for (float t = 0.F; t < longest; t += kReferenceDt) {
      const MissionStep step =
          runner.step(items, estimate, follower.reference(), Vec3::Zero(), landed, kReferenceDt, params);
      for (int seq = runner.take_reached(); seq >= 0; seq = runner.take_reached()) reached.push_back(seq);
      if (step.complete) return t;
      if (step.return_home) returned = true;
      FollowerTarget target = step.target;
      if (step.descend) target.position.z() = -0.1F;
      estimate.p_WB = follower.step(target, kReferenceDt, params).position;
      landed = estimate.p_WB.z() < 0.02F;
    }
    return -1.F;
  }
};

}  // namespace

TEST_CASE("takeoff, waypoints and landing are reached once each and in order") {
  PerfectFlight flight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), to(ItemKind::kWaypoint, {20.F, 0.F, 8.F}),
                        to(ItemKind::kWaypoint, {20.F, 10.F, 8.F}), to(ItemKind::kLand, {0.F, 0.F, 0.F})});
  CHECK(flight.fly(120.F) > 0.F);
  CHECK(flight.reached == std::vector<int>{0, 1, 2, 3});
  CHECK(flight.runner.complete());
  CHECK(flight.estimate.p_WB.head<2>().norm() < 0.6F);
}

TEST_CASE("a landing that is flown past at speed is come back to before it goes down") {
  PerfectFlight flight({to(ItemKind::kLand, {10.F, 0.F, 0.F})});
  flight.landed = false;
  flight.follower.start({4.F, 0.F, 3.F}, {6.F, 0.F, 0.F}, 0.F);
  flight.estimate.p_WB = {4.F, 0.F, 3.F};
  float farthest = 0.F;
  for (int tick = 0; tick < 3000; ++tick) {
    const FlatReference& r = flight.follower.reference();
    const MissionStep step =
        flight.runner.step(flight.items, flight.estimate, r, Vec3::Zero(), false, kReferenceDt, flight.params);
    if (step.descend) break;
    flight.follower.step(step.target, kReferenceDt, flight.params);
    flight.estimate.p_WB = flight.follower.reference().position;
    farthest = std::max(farthest, flight.estimate.p_WB.x());
  }
  CHECK(farthest > 11.F);
  CHECK(std::abs(flight.estimate.p_WB.x() - 10.F) < 0.5F);
  CHECK(flight.follower.reference().velocity.head<2>().norm() < 0.5F);
}

TEST_CASE("a waypoint with a hold is waited at") {
  FlightItem wait = to(ItemKind::kWaypoint, {5.F, 0.F, 5.F});
  const float without = PerfectFlight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), wait}).fly(120.F);
  wait.hold_s = 7.F;
  const float with = PerfectFlight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), wait}).fly(120.F);
  CHECK(with - without == doctest::Approx(7.F).epsilon(0.01));
}

TEST_CASE("a jump repeats as often as it says") {
  PerfectFlight flight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), to(ItemKind::kWaypoint, {6.F, 0.F, 5.F}),
                        to(ItemKind::kWaypoint, {0.F, 6.F, 5.F}), jump(1, 2)});
  CHECK(flight.fly(200.F) > 0.F);
  CHECK(flight.reached == std::vector<int>{0, 1, 2, 3, 1, 2, 3, 1, 2, 3});
}

TEST_CASE("a loop of items that need no time does not hang the tick") {
  PerfectFlight flight({FlightItem{}, jump(0, -1)});
  CHECK(flight.fly(1.F) == -1.F);
}

TEST_CASE("a return item hands over and completes the mission") {
  FlightItem home;
  home.kind = ItemKind::kReturn;
  PerfectFlight flight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), home});
  flight.fly(60.F);
  CHECK(flight.returned);
  CHECK(flight.runner.complete());
}

TEST_CASE("items that the ground station flew are reached when it reports them") {
  MissionRunner runner;
  runner.reset(0);
  runner.take_over(3);
  CHECK(runner.take_reached() == 0);
  CHECK(runner.take_reached() == 1);
  CHECK(runner.take_reached() == 2);
  CHECK(runner.take_reached() == -1);
  CHECK(runner.current() == 3);
}

TEST_CASE("a mission that begins with a waypoint climbs before it crosses") {
  PerfectFlight flight({to(ItemKind::kWaypoint, {30.F, 0.F, 2.F})});
  for (int i = 0; i < 60; ++i) {
    const MissionStep step = flight.runner.step(flight.items, flight.estimate, flight.follower.reference(),
                                                Vec3::Zero(), true, kReferenceDt, flight.params);
    CHECK(step.target.position.x() == 0.F);
    CHECK(step.target.position.z() == doctest::Approx(flight.params.takeoff_altitude));
  }
}

TEST_CASE("a turn is waited for, and the heading it gave is kept for what follows") {
  FlightItem turn;
  turn.kind = ItemKind::kYaw;
  turn.has_yaw = true;
  turn.yaw = 1.5F;
  PerfectFlight flight({to(ItemKind::kTakeoff, {0.F, 0.F, 5.F}), turn, to(ItemKind::kWaypoint, {10.F, 0.F, 5.F})});
  CHECK(flight.fly(60.F) > 0.F);
  CHECK(flight.follower.reference().yaw == doctest::Approx(1.5F).epsilon(0.05));
}

TEST_CASE("home from an item is where the item says, and nothing flies there") {
  FlightItem home = to(ItemKind::kSetHome, {30.F, 20.F, 0.F});
  MissionRunner runner;
  runner.reset(0);
  List items;
  items.items = {home};
  const MissionStep step = runner.step(items, Estimate{}, FlatReference{}, Vec3::Zero(), false, kReferenceDt, Params{});
  CHECK(step.set_home);
  CHECK(step.home == Vec3(30.F, 20.F, 0.F));
  CHECK(step.target.position.norm() < 1e-6F);
}

TEST_CASE("a hundred items flown by the ground station are all told, each once") {
  MissionRunner runner;
  runner.reset(0);
  runner.take_over(100);
  for (int i = 0; i < 100; ++i) CHECK(runner.take_reached() == i);
  CHECK(runner.take_reached() == -1);
}
