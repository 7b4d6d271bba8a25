// One flight in this process, from switch-on to the end of a plan: autopilot and world as halfroll-sitl has them, and
// the ground's side of the flight: start, take-over, references at 100 Hz through MAVLink bytes over a modelled link.
// Why: campaigns fly thousands; over a link that is ideal every bit is that of a flight through processes and sockets.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "autopilot.hpp"
#include "sim/world.hpp"
#include "stream/radio.hpp"
#include "stream/references.hpp"

namespace halfroll::stream {

using Bytes = std::vector<std::uint8_t>;

/// How the flight of a plan ended.
enum class Ending : std::uint8_t {
  kFlown,         // to the plan's end, and hovered there
  kDidNotStart,   // was not armed, or did not reach the height of its take-off
  kNeverSettled,  // not at rest at the plan's start in time
  kLeftPlan,      // farther from it than the ground station follows
  kReleased,      // the autopilot left OFFBOARD or disarmed
  kCrashed,
};

/// What is flown: gently to the plan's start, the plan, and a hover at its end.
struct Task {
  std::shared_ptr<const Path> approach, plan;
  double duration = 0.0;  // [s], the plan's
  double hold_s = 0.0;
  Vec3d start = Vec3d::Zero();
};

class Sortie {
 public:
  /// Standing at the origin, switched off. `mission` is an image as stored_mission() gives it.
  Sortie(const Vehicle& vehicle, const Params& params, const sim::Plant& plant, const sim::Scenario& scenario,
         std::uint64_t seed, const link::Origin& origin, Bytes mission);
  Sortie(const Sortie&) = delete;  // the autopilot was booted from `mission`
  Sortie& operator=(const Sortie&) = delete;

  /// Bytes to a link while no time passes; frames of that link.
  std::vector<Bytes> service(const Bytes& bytes, int link);
  const Bytes& stored_mission() const { return stored_; }

  /// Sends the commands as soon as home is known, the last of them, which arms, every half second until it is obeyed;
  /// flies until mission item `first_item` is reached. False if that has not happened after `patience_s`.
  bool take_off(const std::vector<Bytes>& commands, int first_item, double patience_s);

  /// From now, at a tick: takes over with the command, and streams until the task has ended.
  Ending follow(const Task& task, References references, const Bytes& take_over, const RadioSetup& radio);

  std::uint64_t t_us() const { return autopilot_.t_us(); }
  const Autopilot& autopilot() const { return autopilot_; }
  const sim::World& world() const { return world_; }
  std::uint64_t plan_start_us() const { return plan_start_us_; }
  std::uint64_t plan_end_us() const { return plan_end_us_; }  // the tick at or after it; 0 if it was not reached

  /// A row each millisecond from 0: true position when the commands were given (single precision, as a log has them).
  const std::vector<std::array<float, 3>>& positions() const { return positions_; }
  const std::vector<std::array<float, 4>>& commands() const { return commands_; }

 private:
  struct Sample {
    std::uint64_t t_us;
    Estimate estimate;
  };
  struct Stream;

  void step();
  void hear(const LinkOutputs& out);
  LinkInputs inputs(const link::Datagram& datagram);
  bool at_tick() const { return t_us() % kTickUs == 0; }
  bool is_lost() const;

  Bytes image_, stored_;
  sim::Model model_;
  sim::World world_;
  Autopilot autopilot_;
  link::StorageSlot storing_ = link::StorageSlot::kNone;
  std::uint8_t sequence_ = 0;
  int first_item_ = 0;
  /// As a ground station hears it on link A, frame by frame.
  struct Heard {
    bool home = false;     // is known
    bool reached = false;  // the item that the take-off leads to
  };
  Heard heard_, heard_at_tick_;  // the latter when the state came last
  std::uint64_t plan_start_us_ = 0, plan_end_us_ = 0;
  std::vector<std::array<float, 3>> positions_;
  std::vector<std::array<float, 4>> commands_;
};

}  // namespace halfroll::stream
