// What makes the autopilot act by itself. Why: condition, action and recovery stand in one table (docs/mavlink.md
// prints it), and of two that act at once the stronger one wins, whatever their order.
#pragma once
#include <array>

#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

enum class FailsafeCause : std::uint8_t {
  kAttitudeLost,
  kRotor,
  kPositionLost,
  kBatteryCritical,
  kBatteryLow,
  kFence,
  kGroundLost,
  kOffboardLost
};
inline constexpr std::size_t kFailsafeCount = 8;

/// In order of strength.
enum class FailsafeAction : std::uint8_t { kNone, kWarn, kMission, kHold, kReturn, kLand, kTerminate };

/// What the conditions look at.
struct FailsafeInputs {
  bool flying = false;           // armed and off the ground
  bool offboard = false;         // the stream decides where the body points
  bool attitude_valid = true;    // of the estimate
  bool position_valid = true;    //
  float axis_cosine = 1.F;       // between the thrust axis and its reference
  float rate_error = 0.F;        // [rad/s], against the reference
  float state_of_charge = 1.F;   // 0..1
  float ground_silence_s = 0.F;  // since the last heartbeat of a ground station; 0 while none has been heard
  float distance = 0.F;          // [m] from home, horizontally
  float height = 0.F;            // [m] above home
  int suspect_rotor = 0;         // 1..4 (rotor_monitor.hpp), 0: none
  bool offboard_lost = false;    // last rung of the ladder (offboard.hpp)
};

struct FailsafeRow {
  FailsafeCause cause;
  const char* words;      // of the text; what follows them is the action
  const char* condition;  // these three for docs/mavlink.md
  const char* action_in_words;
  const char* recovery;
  bool (*begins)(const FailsafeInputs&, const Params&);
  bool (*ends)(const FailsafeInputs&, const Params&);
  float (*lasting_s)(const Params&);  // the condition must hold this long
  FailsafeAction (*action)(const Params&);
};
extern const std::array<FailsafeRow, kFailsafeCount> kFailsafes;

/// Whether a place that far from home, and that high above it, may not be chosen: beyond a fence that would act there.
bool fence_forbids(float distance, float height, const Params& params);

class Failsafes {
 public:
  /// Rows that began or ended in this tick, bit n for row n of kFailsafes.
  struct Change {
    std::uint32_t begun = 0, ended = 0;
  };

  /// One 10 ms tick in flight or armed on the ground.
  Change step(const FailsafeInputs& in, float dt, const Params& params);
  void reset() { *this = Failsafes{}; }

  bool active(FailsafeCause cause) const { return (active_ >> static_cast<unsigned>(cause) & 1U) != 0; }
  /// Something stronger than a warning goes on.
  bool acting(const Params& params) const;
  /// The rotor that was found faulty, 1..4; 0: none.
  int faulty_rotor() const { return faulty_rotor_; }

  auto state() const { return std::tie(active_, lasting_s_, faulty_rotor_); }

 private:
  std::uint32_t active_ = 0;
  std::array<float, kFailsafeCount> lasting_s_ = {};
  int faulty_rotor_ = 0;
};

}  // namespace halfroll
