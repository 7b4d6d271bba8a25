// Flies stored mission items one after the other. Why: a mission must be flown to its end without any ground station.
#pragma once
#include "core/flight_item.hpp"
#include "core/follower.hpp"
#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

inline constexpr float kTakeoffReached = 0.3F;  // [m], vertical: a climb has arrived

/// Where items come from; the autopilot answers from its store, converted to W.
class MissionItems {
 public:
  virtual int count() const = 0;
  virtual int first() const = 0;  // 1 where item 0 is only the home of a file
  virtual FlightItem item(int seq) const = 0;

 protected:
  ~MissionItems() = default;
};

/// What the runner wants of the autopilot this tick.
struct MissionStep {
  FollowerTarget target;
  bool descend = false;      // go down until landed
  bool return_home = false;  // an RTL item: hand over to mode RTL
  bool complete = false;     // nothing left to fly
  bool set_home = false;     // home becomes `home`
  Vec3 home = Vec3::Zero();
};

class MissionRunner {
 public:
  static constexpr int kMaxItems = 2000;

  void reset(int first);      // a new mission, or begin again
  void set_current(int seq);  // continue with this item
  void set_current_and_clear_jumps(int seq);
  void resume();            // re-enter the current item (mode MISSION entered)
  void take_over(int seq);  // the ground station flew up to here: items before seq are reached
  int current() const { return current_; }
  bool complete() const { return complete_; }
  void set_speed(float speed) {  // [m/s]; -1 keep, -2 default
    if (speed != -1.F) speed_ = speed;
  }

  /// One 10 ms tick. `home` in W; `landed` ends a LAND item. Reached items: take_reached().
  MissionStep step(const MissionItems& items, const Estimate& estimate, const FlatReference& reference,
                   const Vec3& home, bool landed, float dt, const Params& params);

  /// Next item reached since last asked, in order, or -1.
  int take_reached();

  auto state() const {
    return std::tie(current_, entered_, climbing_, arrived_, waited_s_, speed_, complete_, entry_position_, wanted_yaw_,
                    yaw_known_, jumps_done_, reached_, reached_count_, overtaken_, overtaken_end_);
  }

 private:
  void enter(const FlightItem& item, const Estimate& estimate, const FlatReference& reference, bool landed);
  void reach(int seq);
  void go_to(int seq, const MissionItems& items);

  int current_ = 0;
  bool entered_ = false;
  bool climbing_ = false;  // takeoff, or the first waypoint of a mission without one
  bool arrived_ = false;
  float waited_s_ = 0.F;
  float speed_ = -2.F;  // [m/s], -2: the default
  bool complete_ = false;
  Vec3 entry_position_ = Vec3::Zero();
  float wanted_yaw_ = 0.F;  // of the last item that gave one, else as it was found
  bool yaw_known_ = false;
  std::array<std::uint16_t, kMaxItems> jumps_done_ = {};

  static constexpr int kReachedQueue = 64;
  std::array<std::int16_t, kReachedQueue> reached_ = {};
  int reached_count_ = 0;
  int overtaken_ = 0, overtaken_end_ = 0;  // items the ground station flew, still to be told
};

}  // namespace halfroll
