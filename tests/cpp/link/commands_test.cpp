// Every command of the contract as clients send it, and what makes each of them bad.
#include "link/commands.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "link/mission_items.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
using C = CommandResult;

CommandSituation situation(int count = 5) { return {{473977420, 85455940, 488000}, 2.F, false, count}; }

Wish ask(std::uint16_t command, std::array<float, 7> p = {}, const CommandSituation& now = situation()) {
  Command c;
  c.command = command;
  c.p = p;
  return read_command(c, now);
}
Wish ask_int(std::uint16_t command, std::uint8_t frame, std::array<float, 4> p, std::int32_t x, std::int32_t y,
             float z) {
  Command c;
  c.command = command;
  c.is_int = true;
  c.frame = frame;
  c.p = {p[0], p[1], p[2], p[3], 0, 0, z};
  c.x = x;
  c.y = y;
  return read_command(c, situation());
}

template <class W>
const W& wanted(const Wish& wish) {
  static const W none{};
  const W* found = std::get_if<W>(&wish);
  CHECK(found != nullptr);
  return found != nullptr ? *found : none;
}
bool is(const Wish& wish, CommandResult result) {
  const auto* found = std::get_if<CommandResult>(&wish);
  return found != nullptr && *found == result;
}
template <class W>
bool is(const Wish& wish) {
  return std::holds_alternative<W>(wish);
}

}  // namespace

TEST_CASE("arming: unused parameters may be zero or NaN, anything else is denied") {
  CHECK(wanted<ArmWish>(ask(400, {1, 0, 0, 0, 0, 0, 0})).arm);
  CHECK(wanted<ArmWish>(ask(400, {1, kNan, kNan, kNan, kNan, kNan, kNan})).arm);
  CHECK_FALSE(wanted<ArmWish>(ask(400, {0})).arm);
  CHECK(wanted<ArmWish>(ask(400, {0, 21196})).force);
  CHECK(wanted<ArmWish>(ask(400, {1, 2989})).force);
  CHECK(is(ask(400, {0, 2989}), C::kDenied));
  CHECK(is(ask(400, {2}), C::kDenied));
  CHECK(is(ask(400, {kNan}), C::kDenied));
  CHECK(is(ask(400, {1, 0, 1}), C::kDenied));
  CHECK(is(ask(400, {1, 0, 0, 0, 0, 0, 1}), C::kDenied));
  CHECK(is<ArmWish>(ask_int(400, 0, {1, 0, 0, 0}, INT32_MAX, INT32_MAX, kNan)));
  CHECK(is(ask_int(400, 0, {1, 0, 0, 0}, 5, 0, 0), C::kDenied));
}

TEST_CASE("modes are chosen by main and sub, packed, by SET_MODE, or as a standard mode") {
  CHECK(wanted<ModeWish>(ask(176, {1, 4, 4})).mode == Mode::kMission);
  CHECK(wanted<ModeWish>(ask(176, {29, 6, kNan, kNan, kNan, kNan, kNan})).mode == Mode::kOffboard);
  CHECK(wanted<ModeWish>(ask(176, {157, 67371008})).mode == Mode::kMission);
  CHECK(wanted<ModeWish>(ask(176, {1, 393216, kNan})).mode == Mode::kOffboard);
  CHECK(wanted<ModeWish>(ask(176, {1, 6, 0})).mode == Mode::kOffboard);
  for (const WireModeRow& row : kWireModes) {
    CHECK(wanted<ModeWish>(read_set_mode({1, row.custom_mode})).mode == row.mode);
    CHECK(wanted<ModeWish>(ask(176, {1, static_cast<float>(row.custom_mode)})).mode == row.mode);
  }
  for (const float main : {0.F, 1.F, 2.F, 3.F, 5.F, 7.F, 9.F}) CHECK(is(ask(176, {1, main}), C::kDenied));
  for (const float sub : {0.F, 1.F, 8.F, 9.F, 255.F, 0.5F}) CHECK(is(ask(176, {1, 4, sub}), C::kDenied));
  for (const float base : {kNan, 0.F, 28.F, 1.5F, -1.F, 257.F, kInf}) CHECK(is(ask(176, {base, 4, 4}), C::kDenied));
  for (const float main : {kNan, kInf, 1e30F, -1.F}) CHECK(is(ask(176, {1, main}), C::kDenied));
  CHECK(is(read_set_mode({0, 67371008}), C::kDenied));
  CHECK(is(read_set_mode({1, 4}), C::kDenied));
  CHECK(wanted<ModeWish>(ask(262, {6})).mode == Mode::kMission);
  CHECK(wanted<ModeWish>(ask(262, {7})).mode == Mode::kLand);
  for (const float p : {0.F, 1.F, 9.F, kNan}) CHECK(is(ask(262, {p}), C::kFailed));
}

TEST_CASE("a takeoff height is above home, above sea level by frame or identity, or the parameter's") {
  CHECK(wanted<TakeoffWish>(ask(22, {0, 0, 0, 0, 0, 0, 5})).height == 5.F);
  CHECK_FALSE(wanted<TakeoffWish>(ask(22, {kNan, kNan, kNan, kNan, kNan, kNan, kNan})).height.has_value());
  CHECK(*wanted<TakeoffWish>(ask_int(22, 0, {}, 0, 0, 500)).height == doctest::Approx(10.F));
  CHECK(*wanted<TakeoffWish>(ask_int(22, 3, {}, 0, 0, 10)).height == doctest::Approx(10.F));
  CommandSituation px4 = situation();
  px4.px4_identity = true;
  CHECK(*wanted<TakeoffWish>(ask(22, {0, 0, 0, 0, 0, 0, 500}, px4)).height == doctest::Approx(10.F));
  for (const float z : {0.4F, 501.F, 0.F, -5.F, kInf}) CHECK(is(ask(22, {0, 0, 0, 0, 0, 0, z}), C::kDenied));
  CHECK(is(ask_int(22, 9, {}, 0, 0, 10), C::kDenied));
}

TEST_CASE("the other flight commands") {
  CHECK(is<LandWish>(ask(21, {0, 0, 0, kNan, 47.F, 8.F, 0})));
  CHECK(is<ReturnWish>(ask(20)));
  CHECK(is(ask(20, {0, 0, 0, 0, 0, 0, 1}), C::kDenied));
  CHECK(wanted<MissionStartWish>(ask(300)).item == -1);
  CHECK(wanted<MissionStartWish>(ask(300, {kNan, kNan})).item == -1);
  CHECK(wanted<MissionStartWish>(ask(300, {4})).item == 4);
  CHECK(is(ask(300, {5}), C::kDenied));
  CHECK(is(ask(300, {}, situation(0)), C::kTemporarilyRejected));
  CHECK(is<PauseWish>(ask(193, {0})));
  CHECK(is<ContinueWish>(ask(193, {1})));
  CHECK(is(ask(193, {2}), C::kDenied));
  CHECK(is(ask(193, {kNan}), C::kDenied));
  CHECK(wanted<MissionCurrentWish>(ask(224, {4, 1})).reset);
  CHECK(wanted<MissionCurrentWish>(ask(224, {-1})).seq == -1);
  for (const float seq : {5.F, -2.F, 0.5F, 65535.F, 1e9F, kNan, kInf}) CHECK(is(ask(224, {seq}), C::kDenied));
  CHECK(is(ask(224, {0}, situation(0)), C::kTemporarilyRejected));
}

TEST_CASE("a reposition keeps what is not given and refuses what is too far or below the ground") {
  const RepositionWish stop = wanted<RepositionWish>(ask(192, {-1, 1, 0, kNan, kNan, kNan, kNan}));
  CHECK(stop.change_to_hold);
  CHECK_FALSE((stop.has_position || stop.has_height || stop.has_yaw || stop.speed.has_value()));
  const RepositionWish go = wanted<RepositionWish>(ask_int(192, 6, {3, 0, 0, 1.F}, 473987420, 85455940, 20));
  CHECK(go.position.x() == doctest::Approx(111.2).epsilon(0.01));
  CHECK(go.position.z() == doctest::Approx(22.F));
  CHECK(go.yaw == -1.F);  // clockwise on the wire
  CHECK(*go.speed == 3.F);
  CHECK(wanted<RepositionWish>(ask(192, {-1, 1, 0, kNan, kNan, kNan, 500})).position.z() == doctest::Approx(12.F));
  CHECK(is(ask_int(192, 6, {-1, 1, 0, kNan}, 483977420, 85455940, 20), C::kDenied));
  CHECK(is(ask_int(192, 6, {-1, 1, 0, kNan}, 473987420, 85455940, -1), C::kDenied));
  CHECK(is(ask(192, {-1, 1, 0, kNan, 47.4F, kNan, kNan}), C::kDenied));
  CHECK(is(ask(192, {-1, 1, 0, kInf, kNan, kNan, kNan}), C::kDenied));
  CHECK(is(ask(192, {-2, 1, 0, kNan, kNan, kNan, kNan}), C::kDenied));
}

TEST_CASE("speed, yaw, inverted flight and flips") {
  CHECK(wanted<SpeedWish>(ask(178, {1, 7, -1})).speed == 7.F);
  CHECK(wanted<SpeedWish>(ask(178, {3, -2})).kind == SpeedWish::Kind::kDescend);
  for (const float speed : {0.F, -3.F, -1.5F, kNan, kInf}) CHECK(is(ask(178, {1, speed}), C::kDenied));
  CHECK(is(ask(178, {4, 5}), C::kDenied));
  CHECK(wanted<YawWish>(ask(115, {90, 0, 1, 0})).yaw == doctest::Approx(-M_PI / 2));
  CHECK(wanted<YawWish>(ask(115, {90, 0, -1, 1})).yaw == doctest::Approx(M_PI / 2));
  CHECK(is(ask(115, {kNan}), C::kDenied));
  CHECK(wanted<InvertedWish>(ask(210, {1})).inverted);
  CHECK(is(ask(210, {2}), C::kDenied));
  CHECK(is(ask(210, {kNan}), C::kDenied));
  const FlipWish flip = wanted<FlipWish>(ask(31010, {2, -1.5F, 8, kNan}));
  CHECK(flip.axis == 2);
  CHECK(flip.turns == -1.5F);
  CHECK(flip.least_height == 8.F);
  CHECK_FALSE(flip.longest_time.has_value());
  for (const float turns : {0.F, 0.3F, 5.5F, kNan, kInf}) CHECK(is(ask(31010, {1, turns}), C::kDenied));
  CHECK(is(ask(31010, {3, 1}), C::kDenied));
}

TEST_CASE("home and origin") {
  CHECK(wanted<HomeWish>(ask(179, {1})).here);
  const HomeWish home = wanted<HomeWish>(ask_int(179, 0, {0, 0, 0, 0}, 473977421, 85455941, 490));
  CHECK_FALSE(home.here);
  CHECK(home.lat_degE7 == 473977421);
  CHECK(home.alt_mm == 490000);
  CHECK(wanted<HomeWish>(ask(179, {0, 0, 0, 0, 47.5F, 8.5F, 490})).lat_degE7 == 475000000);
  CHECK(is(ask(179, {0, 0, 0, 0, 91.F, 8.5F, 490}), C::kDenied));
  CHECK(is(ask(179, {0, 0, 0, 0, 47.F, 8.5F, kNan}), C::kDenied));
  CHECK(is(ask(179, {0}), C::kDenied));
  CHECK(is(ask(179, {kNan}), C::kDenied));
  const OriginWish origin = wanted<OriginWish>(ask_int(611, 0, {0, 0, 0, 0}, 473977421, 85455941, 490.5F));
  CHECK(origin.lat_degE7 == 473977421);
  CHECK(origin.alt_mm == 490500);
  CHECK(wanted<OriginWish>(read_set_origin({1, 2, 3})).alt_mm == 3);
  CHECK(is(read_set_origin({900000001, 2, 3}), C::kDenied));
  CHECK(is(ask_int(611, 0, {0, 0, 0, 0}, 1, 2, kNan), C::kDenied));
}

TEST_CASE("messages by interval and by request") {
  CHECK(wanted<IntervalWish>(ask(511, {31, 10000})).id == 31);
  CHECK(is(ask(511, {kNan, 10000}), C::kDenied));
  CHECK(is(ask(511, {31, kNan}), C::kDenied));
  CHECK(is(ask(511, {-1, 10000}), C::kDenied));
  CHECK(wanted<IntervalQuery>(ask(510, {31})).id == 31);
  CHECK(is(ask(510, {1e20F}), C::kDenied));
  CHECK(wanted<MessageWish>(ask(512, {435, 2, kNan, kNan, kNan, kNan, kNan})).parameter == 2.F);
  CHECK(is(ask(512, {0.5F}), C::kDenied));
  CHECK(wanted<MessageWish>(ask(520, {1})).id == msg::kAutopilotVersion);
  CHECK(wanted<MessageWish>(ask(410)).old_command);
}

TEST_CASE("service commands") {
  CHECK(wanted<PowerWish>(ask(246, {1})).kind == PowerWish::Kind::kReboot);
  CHECK(wanted<PowerWish>(ask(246, {2})).kind == PowerWish::Kind::kShutDown);
  CHECK(is(ask(246, {3}), C::kDenied));
  CHECK(wanted<ParamStorageWish>(ask(245, {1})).kind == ParamStorageWish::Kind::kSave);
  CHECK(wanted<ParamStorageWish>(ask(245, {-1})).kind == ParamStorageWish::Kind::kNothing);
  CHECK(is(ask(245, {3}), C::kDenied));
  CHECK(is(ask(245, {kNan}), C::kDenied));
  CHECK(is<CalibrationWish>(ask(241, {1})));
  CHECK(is<PrearmChecksWish>(ask(401)));
  CHECK(wanted<TerminationWish>(ask(185, {1})).terminate);
  CHECK_FALSE(wanted<TerminationWish>(ask(185, {0})).terminate);
  CHECK(is(ask(185, {0.2F}), C::kDenied));
  CHECK(is(ask(185, {kNan}), C::kDenied));
}

TEST_CASE("mission-only commands are denied, unknown ones unsupported") {
  for (const std::uint16_t c : {16, 17, 19, 82, 93, 112, 177, 31000}) CHECK(is(ask(c), C::kDenied));
  for (const std::uint16_t c : {0, 18, 183, 203, 205, 519, 2000, 3000, 65535}) CHECK(is(ask(c), C::kUnsupported));
}

TEST_CASE("any bits in any field are answered, never undefined") {
  std::mt19937 random(7);
  const std::vector<std::uint16_t> commands = {16,  17,  19,  20,  21,  22,  82,  93,  112, 115, 176,   177,  178,
                                               179, 185, 192, 193, 210, 224, 245, 246, 262, 300, 400,   510,  511,
                                               512, 611, 189, 206, 0,   401, 241, 520, 410, 999, 31000, 31010};
  int accepted = 0;
  for (int n = 0; n < 100000; ++n) {
    const auto number = [&] {  // any bits, or a small number as clients send
      const std::uint32_t bits = random();
      float p = 0.F;
      std::memcpy(&p, &bits, sizeof p);
      return random() % 2 == 0 ? p : static_cast<float>(random() % 9) - 2.F;
    };
    Command c;
    c.command = commands[random() % commands.size()];
    for (float& p : c.p) p = number();
    c.is_int = random() % 2 == 0;
    c.frame = static_cast<std::uint8_t>(random() % 8);
    c.x = static_cast<std::int32_t>(random());
    c.y = static_cast<std::int32_t>(random());
    read_command(c, situation());
    const MissionItem item{{c.p[0], c.p[1], c.p[2], c.p[3]}, c.x, c.y / 2, c.p[6], c.command, c.frame, 1};
    if (check_item(item, n % 3, 500.F) != MissionResult::kAccepted) continue;
    ++accepted;
    const FlightItem flown = flight_item(item, {});
    CHECK_FALSE(std::isnan(flown.position.sum()));
    CHECK(check_mission(&item, 1, n % 3) != MissionResult::kUnsupported);
  }
  CHECK(accepted > 1000);
}
