#include "core/offboard.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace halfroll;

namespace {

constexpr std::uint64_t kSecond = 1000000;

LinkSetpoint good(std::uint32_t stamp_ms = 0) {
  LinkSetpoint s;
  s.thrust = 0.4F;
  s.origin.stamp_ms = stamp_ms;
  s.origin.source = 7;
  return s;
}

}  // namespace

TEST_CASE("the ladder of a silent link: track, drop rates, recover, lose") {
  const Params params;
  Offboard offboard;
  offboard.enter(kSecond);
  CHECK(offboard.stage(kSecond, true, params) == OffboardStage::kWaiting);
  REQUIRE(offboard.accept(good(), kSecond, true, params) == nullptr);
  const auto after = [&](float s) {
    return offboard.stage(kSecond + static_cast<std::uint64_t>(s * 1e6F), true, params);
  };
  CHECK(after(0.02F) == OffboardStage::kTracking);
  CHECK(after(0.05F) == OffboardStage::kNoRates);
  CHECK(after(0.2F) == OffboardStage::kRecovering);
  CHECK(after(0.6F) == OffboardStage::kLost);
}

TEST_CASE("without a first setpoint offboard gives up after a second, but only when armed") {
  const Params params;
  Offboard offboard;
  offboard.enter(0);
  CHECK(offboard.stage(2 * kSecond, true, params) == OffboardStage::kNeverStarted);
  CHECK(offboard.stage(2 * kSecond, false, params) == OffboardStage::kWaiting);
}

TEST_CASE("a setpoint is used whole or not at all") {
  const Params params;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Offboard offboard;
  offboard.enter(0);
  LinkSetpoint s = good();
  s.thrust = 1.01F;
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  s = good();
  s.q_WD.x = nan;
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  s = good();
  s.q_WD = {0.5F, 0.F, 0.F, 0.F};
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  s = good();
  s.w_WD_D.y() = 41.F;
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  s = good();
  s.type_mask = 64;
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  s.type_mask = 128 + 7;
  CHECK(offboard.accept(s, 1000, true, params) != nullptr);
  CHECK(offboard.dropped() == 6);
  CHECK(offboard.stage(2000, true, params) == OffboardStage::kWaiting);
}

TEST_CASE("what the mask ignores may hold anything") {
  const Params params;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Offboard offboard;
  offboard.enter(0);
  LinkSetpoint s = good();
  s.type_mask = 7;
  s.w_WD_D = Vec3::Constant(nan);
  CHECK(offboard.accept(s, 1000, true, params) == nullptr);
  CHECK(offboard.setpoint().w_WD_D == Vec3(Vec3::Zero()));
  s = good();
  s.type_mask = 128;
  s.q_WD = {nan, nan, nan, nan};
  CHECK(offboard.accept(s, 2000, true, params) == nullptr);
  CHECK_FALSE(offboard.setpoint().attitude_used);
}

TEST_CASE("a stamp near vehicle time dates the setpoint, any other means arrival") {
  const Params params;
  Offboard offboard;
  offboard.enter(0);
  REQUIRE(offboard.accept(good(10010), 10 * kSecond, true, params) == nullptr);
  CHECK(offboard.setpoint().t_us == 10010000);
  REQUIRE(offboard.accept(good(99999), 10 * kSecond, true, params) == nullptr);
  CHECK(offboard.setpoint().t_us == 10 * kSecond);
  REQUIRE(offboard.accept(good(0), 10 * kSecond, true, params) == nullptr);
  CHECK(offboard.setpoint().t_us == 10 * kSecond);
}

TEST_CASE("a late older setpoint of the same source is dropped, a restarted clock is not") {
  const Params params;
  Offboard offboard;
  offboard.enter(0);
  REQUIRE(offboard.accept(good(5000), 5 * kSecond, true, params) == nullptr);
  CHECK(offboard.accept(good(4990), 5 * kSecond, true, params) != nullptr);
  CHECK(offboard.accept(good(100), 5 * kSecond, true, params) == nullptr);
}

TEST_CASE("the first good source owns offboard until it has been silent") {
  const Params params;
  Offboard offboard;
  offboard.enter(0);
  REQUIRE(offboard.accept(good(), 1000, true, params) == nullptr);
  LinkSetpoint other = good();
  other.origin.source = 8;
  CHECK(offboard.accept(other, 2000, true, params) != nullptr);
  CHECK(offboard.accept(other, 600000, true, params) == nullptr);
}
