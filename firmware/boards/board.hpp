// What a board must supply, and the loop around the autopilot. Why: a new board is these five functions
// (docs/porting.md); everything above them is the same firmware everywhere.
#pragma once
#include "autopilot.hpp"

namespace halfroll::boards {

/// Who flies: told once, at the start.
struct Start {
  Vehicle vehicle;
  Params params;
  Boot boot;  // the stored images are filled in by the loop
};

enum class Due : std::uint8_t {
  kStart,    // begin (again) with `Turn::start`
  kStep,     // a millisecond has begun: `Turn::inputs` is what sensors and links have brought
  kService,  // links only, no time passes
  kEnd       // nothing more to do
};

/// Filled by wait(); pointers stay valid until the next wait().
struct Turn {
  Start start;
  Inputs inputs;
  bool ask_time = false;  // lockstep: TIMESYNC goes out with the answer
};

class Board {
 public:
  /// Sleep until something is due, and say what.
  virtual Due wait(Turn& turn) = 0;
  /// Rotor commands and frames, at once after the step (or service: then without rotors).
  virtual void act(const Autopilot& autopilot, const RotorCommands* rotors, const LinkOutputs& out) = 0;
  /// The autopilot has started.
  virtual void started(const Autopilot& autopilot) = 0;
  /// What outlives the power, as it was found, or written last.
  virtual link::StoredImage stored(link::StorageSlot slot) = 0;
  virtual link::StorageResult store(const link::StorageRequest& request) = 0;

 protected:
  ~Board() = default;
};

/// What the loop works on. Too large for a stack.
struct Room {
  std::optional<Autopilot> autopilot;
  Turn turn;
};

/// Fly until the board says kEnd.
void run(Board& board, Room& room);

}  // namespace halfroll::boards
