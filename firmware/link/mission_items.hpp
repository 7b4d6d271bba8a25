// What a mission item may contain and what it means. Why: the item table of the contract as data, read by check and
// flight.
#pragma once
#include "core/flight_item.hpp"
#include "link/frames.hpp"
#include "link/messages.hpp"

namespace halfroll::link {

inline constexpr int kMissionCapacity = 2000;

/// First fault of one item, in the contract's order: command, frame, params 1..4, latitude, longitude, height.
/// Item 0 as WAYPOINT in frame 0 may be at 0,0: check_mission judges it.
MissionResult check_item(const MissionItem& item, int seq, float altitude_max_m);

/// What only the whole list shows: jump targets, jump loops without a position, item 0 at 0,0 that is not home.
MissionResult check_mission(const MissionItem* items, int count, int seq0_home);

/// Item 0 is home, not flown (MIS_SEQ0_HOME: 0 never, 1 always, 2 when item 1 is a takeoff).
bool first_is_home(const MissionItem* items, int count, int seq0_home);

/// Where missions are measured from.
struct Datum {
  Origin origin;
  float home_z = 0.F;             // home in W [m]; heights above home are added to it
  float takeoff_altitude = 2.5F;  // [m] above home where an item gives none
};
/// The item as the follower flies it (W, SI).
FlightItem flight_item(const MissionItem& item, const Datum& datum);

/// 210, 31000, 31010: flown in full only by the off-board planner; on board with a text.
enum class OnBoard : std::uint8_t { kFull, kAttitudeNotFlown, kSkipped };
OnBoard on_board(const MissionItem& item);

/// Non-zero 32-bit fingerprint of the items, every bit of them; 0 when there are none.
std::uint32_t mission_id(const MissionItem* items, int count);

}  // namespace halfroll::link
