// What a mission item may contain and what it means. Why: the item table of the contract as data, read by check and
// flight.
#pragma once
#include <array>
#include <optional>

#include "core/flight_item.hpp"
#include "link/frames.hpp"
#include "link/messages.hpp"

namespace halfroll::link {

inline constexpr int kMissionCapacity = 2000;

/// What a parameter may be: a finite number in [least, most], a multiple of `step` if that is not 0; NaN if `open`.
struct ParameterRule {
  float least, most;
  bool open;
  float step;
};
/// Of p1..p4 of a command that a mission may hold.
std::optional<std::array<ParameterRule, 4>> parameter_rules(std::uint16_t command);

/// First fault of one item, in the contract's order: command, frame, params 1..4, latitude, longitude, height.
/// Item 0 as WAYPOINT in frame 0 may be at 0,0: check_mission judges it.
MissionResult check_item(const MissionItem& item, int seq, float altitude_max_m);

/// What only the whole list shows: jump targets, jump loops without a position, item 0 at 0,0 that is not home.
/// In pieces, for a step has little time and chained jumps need many passes.
class MissionCheck {
 public:
  void begin(int count, int seq0_home);
  /// Look at most at so many items. The verdict, once there is one.
  std::optional<MissionResult> go_on(const MissionItem* items, int looks);

  auto state() const { return std::tie(count_, seq0_home_, next_, struck_, changed_, passes_); }

 private:
  bool beyond(int seq) const { return seq >= count_ || passes_[static_cast<std::size_t>(seq)]; }
  bool lets_time_pass(const MissionItem* items, int seq) const;

  int count_ = 0, seq0_home_ = 2;
  int next_ = 0;          // backwards from the end
  int struck_ = 0;        // items known to let time pass
  bool changed_ = false;  // in this pass
  std::array<bool, kMissionCapacity> passes_ = {};
};

/// The same at once.
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

/// Non-zero 32-bit fingerprint of the items, every bit of them; 0 when there are none. May be told them in parts.
class MissionId {
 public:
  void add(const MissionItem* items, int count);
  int count() const { return count_; }
  std::uint32_t id() const;
  bool operator==(const MissionId& o) const { return hash_ == o.hash_ && count_ == o.count_; }

 private:
  std::uint32_t hash_ = 2166136261U;  // FNV-1a over the items as stored
  int count_ = 0;
};

/// The same at once.
std::uint32_t mission_id(const MissionItem* items, int count);

}  // namespace halfroll::link
