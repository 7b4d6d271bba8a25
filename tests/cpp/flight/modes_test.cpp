#include "core/modes.hpp"

#include <doctest/doctest.h>

#include <cstring>

#include "core/arming.hpp"

using namespace halfroll;

namespace {

ModeContext flying() {
  ModeContext c;
  c.armed = true;
  c.on_ground = false;
  c.position_valid = true;
  c.mission_stored = true;
  return c;
}

ArmingContext ready() {
  ArmingContext c;
  c.attitude_valid = c.upright = c.still = c.position_valid = c.battery_sufficient = true;
  return c;
}

}  // namespace

TEST_CASE("a user may enter every mode in flight but takeoff") {
  for (int to = 0; to < kModeCount; ++to) {
    const char* why = refuse_mode(Mode::kHold, static_cast<Mode>(to), Requester::kUser, flying());
    CHECK((why == nullptr) == (static_cast<Mode>(to) != Mode::kTakeoff));
  }
}

TEST_CASE("the ground station takes over only a mission and gives it back only where it owns it") {
  ModeContext c = flying();
  CHECK(refuse_mode(Mode::kMission, Mode::kOffboard, Requester::kGroundStation, c) == nullptr);
  CHECK(refuse_mode(Mode::kHold, Mode::kOffboard, Requester::kGroundStation, c) != nullptr);
  CHECK(refuse_mode(Mode::kReturn, Mode::kMission, Requester::kGroundStation, c) != nullptr);
  CHECK(refuse_mode(Mode::kOffboard, Mode::kMission, Requester::kGroundStation, c) != nullptr);
  c.ground_station_owns_offboard = true;
  CHECK(refuse_mode(Mode::kOffboard, Mode::kMission, Requester::kGroundStation, c) == nullptr);
}

TEST_CASE("every refusal says why") {
  ModeContext none;
  CHECK(std::strcmp(refuse_mode(Mode::kHold, Mode::kMission, Requester::kUser, none), "no mission stored") == 0);
  CHECK(std::strcmp(refuse_mode(Mode::kHold, Mode::kReturn, Requester::kUser, none), "disarmed") == 0);
  none.terminated = true;
  CHECK(std::strcmp(refuse_mode(Mode::kHold, Mode::kOffboard, Requester::kUser, none), "terminated") == 0);
}

TEST_CASE("with a critical battery only landing and returning are left") {
  ModeContext c = flying();
  c.battery_critical = true;
  CHECK(refuse_mode(Mode::kMission, Mode::kHold, Requester::kUser, c) != nullptr);
  CHECK(refuse_mode(Mode::kMission, Mode::kLand, Requester::kUser, c) == nullptr);
  CHECK(refuse_mode(Mode::kMission, Mode::kReturn, Requester::kUser, c) == nullptr);
}

TEST_CASE("arming names the first failing check, and force skips prudence but not possibility") {
  CHECK(refuse_arming(ready(), false) == nullptr);
  ArmingContext c = ready();
  c.upright = c.battery_sufficient = false;
  CHECK(std::strcmp(refuse_arming(c, false), "not upright") == 0);
  CHECK(refuse_arming(c, true) == nullptr);
  c.attitude_valid = false;
  CHECK(std::strcmp(refuse_arming(c, true), "no attitude") == 0);
}

TEST_CASE("a mission that cannot be flown keeps only mission mode from arming") {
  ArmingContext c = ready();
  c.mission_problem = "item 1 is 388 m below home";
  CHECK(refuse_arming(c, false) == nullptr);
  c.mode = Mode::kMission;
  CHECK(std::strcmp(refuse_arming(c, false), "item 1 is 388 m below home") == 0);
}
