// The item table, row by row: what is good is taken, and each bad field gets its own code.
#include "link/mission_items.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

using namespace halfroll;
using namespace halfroll::link;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
using R = MissionResult;

MissionItem at(std::uint16_t command, std::array<float, 4> p = {}, std::uint8_t frame = 3, float z = 10.F) {
  MissionItem item;
  item.command = command;
  item.p = p;
  item.frame = frame;
  item.x = 473977420;
  item.y = 85455940;
  item.z = z;
  return item;
}
MissionItem plain(std::uint16_t command, std::array<float, 4> p = {}) {
  MissionItem item;
  item.command = command;
  item.p = p;
  item.frame = 2;
  return item;
}
R check(const MissionItem& item, int seq = 1) { return check_item(item, seq, 500.F); }

struct Bad {
  MissionItem item;
  R result;
};

}  // namespace

TEST_CASE("every row of the table takes a good item") {
  const std::vector<MissionItem> good = {at(16, {0, 0, 0, kNan}),
                                         at(16, {5, 2, kNan, -370}),
                                         at(82, {1, 0, kNan, 0}),
                                         at(31000, {90, -45, 3, kNan}),
                                         at(31000, {kNan, kNan, kNan, 0}),
                                         at(17, {kNan, kNan, -50, 0}),
                                         at(19, {3, 0, 100, 0}),
                                         at(22, {15, 0, 0, 0}),
                                         at(22, {kNan, kNan, kNan, kNan}, 3, kNan),
                                         at(21, {0, 2, 0, kNan}, 3, kNan),
                                         plain(20, {kNan, kNan, 0, 0}),
                                         plain(93, {-1, -1, -1, -1}),
                                         plain(93, {2.5F, kNan, 12, 30}),
                                         plain(112, {4}),
                                         plain(115, {90, 10, -1, 1}),
                                         plain(177, {0, -1}),
                                         plain(178, {1, 5, -1, 0}),
                                         plain(178, {0, -2}),
                                         plain(179, {1}),
                                         at(179, {0}),
                                         plain(189),
                                         plain(210, {1}),
                                         plain(31010, {1, -2.5F, kNan, kNan}),
                                         plain(31010, {2, 5, 8, 3}),
                                         plain(206, {25, 0, 1, 0}),
                                         plain(2000, {0, 2, kNan, 1}),
                                         plain(531, {kNan, kNan, kNan, kNan}),
                                         at(16, {}, 0),
                                         at(16, {}, 5),
                                         at(16, {}, 6)};
  for (const MissionItem& item : good) {
    CAPTURE(item.command);
    CHECK(check(item) == R::kAccepted);
  }
}

TEST_CASE("every stored-and-skipped command is taken") {
  for (const std::uint16_t command : {195, 197, 201, 203, 204,  205,  206,  214,  181,  183, 187,
                                      211, 530, 531, 532, 1000, 1001, 2000, 2001, 2500, 2501}) {
    MissionItem item = plain(command);
    item.z = kNan;
    CHECK(check(item) == R::kAccepted);
    item.p[2] = kInf;
    CHECK(check(item) == R::kInvalidParam3);
  }
}

TEST_CASE("everything else is unsupported") {
  for (const std::uint16_t command : {0, 18, 31, 84, 85, 3000, 5000, 5001, 5100, 176, 400, 65535}) {
    CHECK(check(at(command)) == R::kUnsupported);
  }
}

TEST_CASE("each bad field has its own code") {
  const std::vector<Bad> bad = {
      {at(16, {}, 2), R::kUnsupportedFrame},
      {at(16, {}, 1), R::kUnsupportedFrame},
      {at(16, {}, 10), R::kUnsupportedFrame},
      {at(22, {}, 2), R::kUnsupportedFrame},
      {at(21, {}, 2), R::kUnsupportedFrame},
      {at(179, {0}, 2), R::kUnsupportedFrame},
      {at(31010, {1, 1}, 3), R::kUnsupportedFrame},
      {at(16, {-1}), R::kInvalidParam1},
      {at(16, {kNan}), R::kInvalidParam1},
      {at(16, {kInf}), R::kInvalidParam1},
      {at(16, {0, -1}), R::kInvalidParam2},
      {at(16, {0, kNan}), R::kInvalidParam2},
      {at(16, {0, 0, 1}), R::kInvalidParam3},
      {at(16, {0, 0, 0, kInf}), R::kInvalidParam4},
      {at(82, {0, 1}), R::kInvalidParam2},
      {at(82, {0, 0, 0, 1}), R::kInvalidParam4},
      {at(31000, {181, 0}), R::kInvalidParam1},
      {at(31000, {0, 91}), R::kInvalidParam2},
      {at(31000, {kNan, 0}), R::kInvalidParam1},
      {at(31000, {0, kNan}), R::kInvalidParam2},
      {at(31000, {0, 0, -1}), R::kInvalidParam3},
      {at(19, {-1}), R::kInvalidParam1},
      {at(22, {0, 1}), R::kInvalidParam2},
      {at(22, {0, 0, 1}), R::kInvalidParam3},
      {at(21, {0, 3}), R::kInvalidParam2},
      {plain(20, {1}), R::kInvalidParam1},
      {plain(20, {0, 0, 0, 1}), R::kInvalidParam4},
      {plain(93, {-2}), R::kInvalidParam1},
      {plain(93, {-0.5F}), R::kInvalidParam1},
      {plain(112, {-1}), R::kInvalidParam1},
      {plain(115, {kNan}), R::kInvalidParam1},
      {plain(177, {-1}), R::kInvalidParam1},
      {plain(177, {0.5F}), R::kInvalidParam1},
      {plain(177, {0, -2}), R::kInvalidParam2},
      {plain(178, {4, 5}), R::kInvalidParam1},
      {plain(178, {1, 0}), R::kInvalidParam2},
      {plain(178, {1, -0.5F}), R::kInvalidParam2},
      {plain(178, {1, kNan}), R::kInvalidParam2},
      {plain(179, {2}), R::kInvalidParam1},
      {plain(210, {2}), R::kInvalidParam1},
      {plain(31010, {3, 1}), R::kInvalidParam1},
      {plain(31010, {1, 0}), R::kInvalidParam2},
      {plain(31010, {1, 0.3F}), R::kInvalidParam2},
      {plain(31010, {1, 5.5F}), R::kInvalidParam2},
      {plain(31010, {1, 1, kInf}), R::kInvalidParam3},
      {plain(31010, {1, 1, 0, -1}), R::kInvalidParam4},
      {at(16, {}, 3, kNan), R::kInvalidParam7},
      {at(16, {}, 3, 501), R::kInvalidParam7},
      {at(16, {}, 6, -101), R::kInvalidParam7},
      {at(22, {}, 3, 501), R::kInvalidParam7},
      {at(16, {}, 0, kInf), R::kInvalidParam7},
  };
  for (const Bad& b : bad) {
    CAPTURE(b.item.command);
    CAPTURE(b.item.p[0]);
    CAPTURE(b.item.p[1]);
    CHECK(static_cast<int>(check(b.item)) == static_cast<int>(b.result));
  }
  CHECK(check(at(16, {}, 0, 4000)) == R::kAccepted);  // above sea level: judged when the mission starts
}

TEST_CASE("places beyond the poles and the date line, and nowhere, are refused") {
  MissionItem item = at(16);
  item.x = 900000001;
  CHECK(check(item) == R::kInvalidParam5);
  item = at(16);
  item.y = -1800000001;
  CHECK(check(item) == R::kInvalidParam6);
  item = at(16);
  item.x = item.y = 0;
  CHECK(check(item) == R::kInvalidParam5);
  item.frame = 0;
  CHECK(check(item, 0) == R::kAccepted);  // may be the home of a file: judged with the whole list
  CHECK(check(item, 1) == R::kInvalidParam5);
}

TEST_CASE("a takeoff or landing without a place is here") {
  for (const std::int32_t nowhere : {0, INT32_MAX, INT32_MIN}) {
    MissionItem item = at(22);
    item.x = item.y = nowhere;
    CHECK(check(item) == R::kAccepted);
    CHECK_FALSE(flight_item(item, {}).has_position);
  }
  CHECK(flight_item(at(22), {}).has_position);
}

TEST_CASE("the first fault in the stated order is named") {
  MissionItem item = at(9999, {kNan, -1, 1, kInf}, 2, kNan);
  item.x = INT32_MAX;
  item.y = INT32_MAX;
  CHECK(check(item) == R::kUnsupported);
  item.command = 16;
  CHECK(check(item) == R::kUnsupportedFrame);
  item.frame = 3;
  CHECK(check(item) == R::kInvalidParam1);
  item.p[0] = 0;
  CHECK(check(item) == R::kInvalidParam2);
  item.p[1] = 0;
  CHECK(check(item) == R::kInvalidParam3);
  item.p[2] = 0;
  CHECK(check(item) == R::kInvalidParam4);
  item.p[3] = 0;
  CHECK(check(item) == R::kInvalidParam5);
  item.x = 0;
  CHECK(check(item) == R::kInvalidParam6);
  item.y = 1;
  CHECK(check(item) == R::kInvalidParam7);
  item.z = 0;
  CHECK(check(item) == R::kAccepted);
}

TEST_CASE("item 0 is home exactly when it is a waypoint above sea level before a takeoff, or when told so") {
  std::vector<MissionItem> items = {at(16, {}, 0), at(22), at(16)};
  CHECK(first_is_home(items.data(), 3, 2));
  CHECK_FALSE(first_is_home(items.data(), 3, 0));
  items[0].frame = 3;
  CHECK_FALSE(first_is_home(items.data(), 3, 2));
  CHECK(first_is_home(items.data(), 3, 1));
  items[0].frame = 0;
  items[1].command = 16;
  CHECK_FALSE(first_is_home(items.data(), 3, 2));
}

TEST_CASE("item 0 at zero is refused unless it is home") {
  std::vector<MissionItem> items = {at(16, {}, 0), at(22), at(16)};
  items[0].x = items[0].y = 0;
  CHECK(check_mission(items.data(), 3, 2) == R::kAccepted);
  CHECK(check_mission(items.data(), 3, 0) == R::kInvalidParam5);
  items[1] = at(16);
  CHECK(check_mission(items.data(), 3, 2) == R::kInvalidParam5);
}

TEST_CASE("a jump must stay inside the mission and its loop must go somewhere") {
  const auto jump = [](float to) { return plain(177, {to, 3}); };
  std::vector<MissionItem> items = {at(22), at(16), jump(1), plain(178, {1, 5})};
  CHECK(check_mission(items.data(), 4, 2) == R::kAccepted);
  items[2] = jump(4);
  CHECK(check_mission(items.data(), 4, 2) == R::kInvalidParam1);
  items[2] = jump(2);
  CHECK(check_mission(items.data(), 4, 2) == R::kInvalidParam1);
  items = {at(22), plain(178, {1, 5}), plain(93, {1}), jump(1)};
  CHECK(check_mission(items.data(), 4, 2) == R::kInvalidParam1);
  items = {at(22), jump(2), jump(1), at(16)};
  CHECK(check_mission(items.data(), 4, 2) == R::kInvalidParam1);  // round and round, though each goes elsewhere
}

TEST_CASE("a stored item becomes a place in north-west-up") {
  Datum datum;
  datum.origin = {473977420, 85455940, 488000};
  datum.home_z = 2.F;
  MissionItem item = at(16, {3, 1.5F, 0, 90}, 3, 10.F);
  item.x += 1000;
  item.y += 1000;
  FlightItem f = flight_item(item, datum);
  CHECK(f.kind == ItemKind::kWaypoint);
  CHECK(f.position.x() == doctest::Approx(11.12).epsilon(0.01));  // north
  CHECK(f.position.y() == doctest::Approx(-7.54).epsilon(0.01));  // east is negative west
  CHECK(f.position.z() == 12.F);
  CHECK(f.yaw == doctest::Approx(-M_PI / 2));
  CHECK(f.hold_s == 3.F);
  CHECK(f.radius == 1.5F);
  item.frame = 0;
  item.z = 500.F;
  CHECK(flight_item(item, datum).position.z() == doctest::Approx(12.F));
  CHECK(flight_item(at(22, {kNan, kNan, kNan, kNan}, 3, kNan), datum).position.z() == doctest::Approx(4.5F));
  CHECK(std::isinf(flight_item(at(17), datum).hold_s));
  CHECK(flight_item(plain(93, {-1}), datum).hold_s == 0.F);
  f = flight_item(plain(177, {7, -1}), datum);
  CHECK(f.jump_to == 7);
  CHECK(f.repeats == -1);
  CHECK(flight_item(plain(2000), datum).kind == ItemKind::kSkip);
  CHECK(flight_item(plain(31010, {1, 1}), datum).kind == ItemKind::kSkip);
  CHECK(flight_item(plain(20), datum).kind == ItemKind::kReturn);
}

TEST_CASE("what only the planner flies is known") {
  CHECK(on_board(at(31000, {90, 0, 0, 0})) == OnBoard::kAttitudeNotFlown);
  CHECK(on_board(at(31000, {kNan, kNan, 0, 0})) == OnBoard::kFull);
  CHECK(on_board(plain(31010, {1, 1})) == OnBoard::kSkipped);
  CHECK(on_board(plain(210, {1})) == OnBoard::kSkipped);
  CHECK(on_board(at(16)) == OnBoard::kFull);
}

TEST_CASE("every bit of every item counts in the mission id") {
  std::vector<MissionItem> items = {at(22), at(16), at(21)};
  const std::uint32_t id = mission_id(items.data(), 3);
  CHECK(id != 0);
  CHECK(mission_id(items.data(), 0) == 0);
  items[1].frame = 6;
  CHECK(mission_id(items.data(), 3) != id);
  items[1].frame = 3;
  items[1].p[2] = kNan;
  CHECK(mission_id(items.data(), 3) != id);
  items[1].p[2] = -0.F;
  CHECK(mission_id(items.data(), 3) != id);
  items[1].p[2] = 0.F;
  CHECK(mission_id(items.data(), 3) == id);
}

TEST_CASE("the check of a mission that needs many passes comes to the same end in pieces, a few items at a time") {
  // Each jump leads to the one before, the first to a landing: a pass, from the end, settles one link of the chain.
  std::vector<MissionItem> items(60);
  for (std::size_t i = 0; i < items.size(); i += 2) {
    items[i].command = cmd::kJump;
    items[i].p = {static_cast<float>(i) - 2.F, 1.F, 0.F, 0.F};
    items[i + 1].command = cmd::kWaypoint;
  }
  items[0].command = cmd::kLand;
  for (const bool leads_out : {true, false}) {
    if (!leads_out) items[30].p[0] = 30.F;  // jumps to itself
    const MissionResult at_once = check_mission(items.data(), 60, 2);
    CHECK(at_once == (leads_out ? MissionResult::kAccepted : MissionResult::kInvalidParam1));
    MissionCheck check;
    check.begin(60, 2);
    std::optional<MissionResult> result;
    int pieces = 0;
    for (; !result; ++pieces) result = check.go_on(items.data(), 7);
    CHECK(*result == at_once);
    CHECK(pieces > 9);
  }
}
