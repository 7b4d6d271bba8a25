#include "core/failsafes.hpp"

#include <doctest/doctest.h>

#include <cstring>
#include <string>

using namespace halfroll;

namespace {

constexpr float kTick = 0.01F;

FailsafeInputs flying() {
  FailsafeInputs in;
  in.flying = true;
  return in;
}

bool has(std::uint32_t rows, FailsafeCause cause) { return (rows >> static_cast<unsigned>(cause) & 1U) != 0; }

/// Ticks until the cause begins, up to ten seconds; -1: never.
int ticks_until(FailsafeCause cause, const FailsafeInputs& in, const Params& params = {}) {
  Failsafes failsafes;
  for (int tick = 1; tick <= 1000; ++tick) {
    if (has(failsafes.step(in, kTick, params).begun, cause)) return tick;
  }
  return -1;
}

}  // namespace

TEST_CASE("the table's rows stand in the order of their causes, and every one says what, when and how it ends") {
  for (std::size_t i = 0; i < kFailsafeCount; ++i) {
    CHECK(static_cast<std::size_t>(kFailsafes[i].cause) == i);
    for (const char* words :
         {kFailsafes[i].words, kFailsafes[i].condition, kFailsafes[i].action_in_words, kFailsafes[i].recovery}) {
      CHECK(std::strlen(words) > 0);
    }
  }
}

TEST_CASE("a sound flight triggers nothing") {
  Failsafes failsafes;
  for (int tick = 0; tick < 1000; ++tick) CHECK(failsafes.step(flying(), kTick, {}).begun == 0);
}

TEST_CASE("each condition begins after the time that its parameter gives") {
  FailsafeInputs in = flying();
  in.axis_cosine = -1.F;
  CHECK(ticks_until(FailsafeCause::kAttitudeLost, in) == doctest::Approx(200).epsilon(0.02));
  in.offboard = true;
  CHECK(ticks_until(FailsafeCause::kAttitudeLost, in) == -1);
  in = flying();
  in.rate_error = 20.F;
  CHECK(ticks_until(FailsafeCause::kAttitudeLost, in) == doctest::Approx(200).epsilon(0.02));
  in = flying();
  in.attitude_valid = false;
  CHECK(ticks_until(FailsafeCause::kAttitudeLost, in) == doctest::Approx(200).epsilon(0.02));
  in = flying();
  in.suspect_rotor = 3;
  CHECK(ticks_until(FailsafeCause::kRotor, in) == doctest::Approx(30).epsilon(0.05));
  in = flying();
  in.position_valid = false;
  CHECK(ticks_until(FailsafeCause::kPositionLost, in) == 1);
  in = flying();
  in.state_of_charge = 0.05F;
  CHECK(ticks_until(FailsafeCause::kBatteryCritical, in) == 1);
  CHECK(ticks_until(FailsafeCause::kBatteryLow, in) == 1);
  in = flying();
  in.ground_silence_s = 11.F;
  CHECK(ticks_until(FailsafeCause::kGroundLost, in) == 1);
  in = flying();
  in.offboard_lost = true;
  CHECK(ticks_until(FailsafeCause::kOffboardLost, in) == 1);
}

TEST_CASE("a moment of tumbling is forgiven") {
  Failsafes failsafes;
  FailsafeInputs bad = flying();
  bad.axis_cosine = -1.F;
  for (int n = 0; n < 10; ++n) {
    for (int tick = 0; tick < 150; ++tick) CHECK(failsafes.step(bad, kTick, {}).begun == 0);
    failsafes.step(flying(), kTick, {});
  }
}

TEST_CASE("on the ground nothing needs saving but the battery's owner needs telling") {
  FailsafeInputs in;
  in.state_of_charge = 0.F;
  in.position_valid = in.attitude_valid = false;
  in.axis_cosine = -1.F;
  in.suspect_rotor = 1;
  in.ground_silence_s = 100.F;
  Failsafes failsafes;
  std::uint32_t begun = 0;
  for (int tick = 0; tick < 500; ++tick) begun |= failsafes.step(in, kTick, {}).begun;
  CHECK(begun == 1U << static_cast<unsigned>(FailsafeCause::kBatteryLow));
}

TEST_CASE("a fence without limits does not exist, one with limits has a lee of a metre") {
  Params params;
  FailsafeInputs in = flying();
  in.distance = in.height = 1e4F;
  CHECK(ticks_until(FailsafeCause::kFence, in, params) == -1);
  params.fence_distance = 50.F;
  Failsafes failsafes;
  in.height = 0.F;
  in.distance = 50.1F;
  CHECK(has(failsafes.step(in, kTick, params).begun, FailsafeCause::kFence));
  in.distance = 49.5F;
  CHECK_FALSE(has(failsafes.step(in, kTick, params).ended, FailsafeCause::kFence));
  in.distance = 48.9F;
  CHECK(has(failsafes.step(in, kTick, params).ended, FailsafeCause::kFence));
  in.distance = 50.1F;
  CHECK(has(failsafes.step(in, kTick, params).begun, FailsafeCause::kFence));  // and again
}

TEST_CASE("an action of nothing is no failsafe") {
  Params params;
  params.fence_height = 10.F;
  params.fence_action = 0.F;
  FailsafeInputs in = flying();
  in.height = 20.F;
  CHECK(ticks_until(FailsafeCause::kFence, in, params) == -1);
}

TEST_CASE("a faulty rotor stays named until it is disarmed") {
  Failsafes failsafes;
  FailsafeInputs in = flying();
  in.suspect_rotor = 2;
  for (int tick = 0; tick < 50; ++tick) failsafes.step(in, kTick, {});
  in.suspect_rotor = 0;
  for (int tick = 0; tick < 500; ++tick) failsafes.step(in, kTick, {});
  CHECK(failsafes.faulty_rotor() == 2);
  CHECK(failsafes.acting({}));
  failsafes.reset();
  CHECK(failsafes.faulty_rotor() == 0);
}

TEST_CASE("the stronger action is the greater number") {
  CHECK(FailsafeAction::kTerminate > FailsafeAction::kLand);
  CHECK(FailsafeAction::kLand > FailsafeAction::kReturn);
  CHECK(FailsafeAction::kReturn > FailsafeAction::kHold);
  CHECK(FailsafeAction::kHold > FailsafeAction::kWarn);
}
