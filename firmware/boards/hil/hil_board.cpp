#include "boards/hil/hil_board.hpp"

#include <algorithm>
#include <cstring>

namespace halfroll::hil {

using boards::Due;

void HilBoard::take(const std::uint8_t* bytes, std::size_t size) {
  while (size > 0) {
    if (out_size_ == out_.size()) flush();
    const std::size_t n = std::min(size, out_.size() - out_size_);
    std::memcpy(out_.data() + out_size_, bytes, n);
    out_size_ += n;
    bytes += n;
    size -= n;
  }
}

void HilBoard::flush() {
  if (out_size_ > 0) channel_.write(out_.data(), out_size_);
  out_size_ = 0;
}

/// The next whole frame at the beginning of in_; false when the other end is gone. What is no frame is skipped.
bool HilBoard::receive() {
  std::memmove(in_.data(), in_.data() + used_, in_size_ - used_);
  in_size_ -= used_;
  used_ = 0;
  for (;;) {
    std::size_t wanted = kHead;
    if (in_size_ >= kHead) {
      const Head head = read_head(in_.data());
      wanted = kHead + head.size + kTail;
      const bool plausible = head.good && head.size <= kLongestRequest;
      if (plausible && in_size_ >= wanted && is_whole(in_.data(), head.size)) {
        used_ = wanted;
        return true;
      }
      if (!plausible || in_size_ >= wanted) {
        std::memmove(in_.data(), in_.data() + 1, --in_size_);
        continue;
      }
    }
    const std::size_t got = channel_.read(in_.data() + in_size_, in_.size() - in_size_);
    if (got == 0) return false;
    in_size_ += got;
  }
}

Due HilBoard::wait(boards::Turn& turn) {
  if (!greeted_) {
    greeted_ = true;
    write_frame(*this, Kind::kHello, [](auto&) {});
    flush();
  }
  if (!receive()) return Due::kEnd;
  const Head head = read_head(in_.data());
  Reader reader(in_.data() + kHead, head.size);
  Due due = Due::kEnd;
  if (head.kind == Kind::kStart) {
    pass_start(reader, turn.start);
    turn.start.boot.last_words = host_.last_words();
    due = Due::kStart;
  } else if (head.kind == Kind::kStep || head.kind == Kind::kService) {
    read_turn(reader, head.kind, turn, rx_);
    if (const link::Datagram own = host_.heard(); own.size > 0 && turn.inputs.link.rx_count < rx_.size()) {
      rx_[turn.inputs.link.rx_count++] = own;
    }
    due = head.kind == Kind::kStep ? Due::kStep : Due::kService;
  } else {
    write_frame(*this, Kind::kEnd,
                [totals = Totals{host_.stack_bytes(), late_steps_}](auto& writer) { writer(totals); });
    flush();
  }
  began_ = host_.instructions();
  return due;
}

void HilBoard::started(const Autopilot& autopilot) {
  write_frame(*this, Kind::kStart, [&](auto& writer) { pass_params(writer, autopilot.params()); });
  flush();
}

void HilBoard::act(const Autopilot& autopilot, const RotorCommands* rotors, const LinkOutputs& out) {
  Shown shown;
  shown.instructions = host_.instructions() - began_;
  if (rotors != nullptr && shown.instructions > host_.instructions_per_step()) ++late_steps_;
  shown.t_us = autopilot.t_us();
  shown.mode = static_cast<std::uint8_t>(autopilot.mode());
  shown.armed = autopilot.armed();
  shown.time_answered = autopilot.time_answered();
  shown.result_pending = out.store.slot != link::StorageSlot::kNone;
  shown.shut_down = out.shut_down;
  shown.reboot = out.reboot;
  shown.ground_frames = autopilot.ground_frames();
  shown.estimate = autopilot.estimate();
  shown.reference = autopilot.reference();
  shown.state_checksum = autopilot.state_checksum();
  const Kind kind = rotors != nullptr ? Kind::kStep : Kind::kService;
  write_frame(*this, kind, [&](auto& writer) {
    if (rotors != nullptr) writer(*rotors);
    writer(shown);
    write_frames(writer, out);
  });
  flush();
  for (std::size_t i = 0; i < out.tx_count; ++i) host_.say(out.tx[i]);
}

}  // namespace halfroll::hil
