#include "boards/board.hpp"

namespace halfroll::boards {
namespace {

void begin(Board& board, Room& room) {
  Start& start = room.turn.start;
  start.boot.params = board.stored(link::StorageSlot::kParams);
  start.boot.mission = board.stored(link::StorageSlot::kMission);
  start.boot.signing = board.stored(link::StorageSlot::kSigning);
  room.autopilot.emplace(start.vehicle, start.params, start.boot);
  board.started(*room.autopilot);
}

}  // namespace

void run(Board& board, Room& room) {
  link::StorageResult stored;
  for (;;) {
    const Due due = board.wait(room.turn);
    if (due == Due::kEnd) return;
    if (due == Due::kStart) {
      begin(board, room);
      stored = {};
    }
    if (due == Due::kStart || !room.autopilot) continue;
    Autopilot& autopilot = *room.autopilot;
    if (room.turn.ask_time) autopilot.ask_time();
    room.turn.inputs.link.stored = stored;
    Outputs out;
    if (due == Due::kStep) {
      out = autopilot.step(room.turn.inputs);
    } else {
      out.link = autopilot.service(room.turn.inputs.link);
    }
    board.act(autopilot, due == Due::kStep ? &out.rotors : nullptr, out.link);
    stored = board.store(out.link.store);  // when the rotors have their commands: flash is slow
  }
}

}  // namespace halfroll::boards
