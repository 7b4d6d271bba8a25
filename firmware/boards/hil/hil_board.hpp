// A board whose sensors and rotors are at the other end of a byte channel. Why: the simulated world stays on the host,
// and the processor under test runs the loop it would fly with.
#pragma once
#include "boards/hil/frames.hpp"

namespace halfroll::hil {

/// A reliable stream of bytes: semihosted pipes, a serial port, a process's own.
class Channel {
 public:
  /// At least one byte, at most `most`, waiting for it; 0: the other end is gone.
  virtual std::size_t read(std::uint8_t* into, std::size_t most) = 0;
  virtual void write(const std::uint8_t* bytes, std::size_t size) = 0;

 protected:
  ~Channel() = default;
};

/// What this processor knows of its own pace, and keeps without power.
class Host {
 public:
  virtual link::StoredImage stored(link::StorageSlot slot) = 0;
  virtual link::StorageResult store(const link::StorageRequest& request) = 0;
  /// Instructions since some time; differences are used. 0 always: not counted.
  virtual std::uint32_t instructions() { return 0; }
  /// So many are a millisecond.
  virtual std::uint32_t instructions_per_step() { return 0; }
  /// [bytes] that the stack has ever been deep; 0: not measured.
  virtual std::uint32_t stack_bytes() { return 0; }
  /// MAVLink bytes that came by a serial port of the board's own; valid until the next call.
  virtual link::Datagram heard() { return {}; }
  virtual void say(const link::TxFrame&) {}
  /// What is to be told of the time before this start; empty: nothing.
  virtual const char* last_words() { return ""; }

 protected:
  ~Host() = default;
};

class HilBoard final : public boards::Board {
 public:
  HilBoard(Channel& channel, Host& host) : channel_(channel), host_(host) {}

  boards::Due wait(boards::Turn& turn) override;
  void act(const Autopilot& autopilot, const RotorCommands* rotors, const LinkOutputs& out) override;
  void started(const Autopilot& autopilot) override;
  link::StoredImage stored(link::StorageSlot slot) override { return host_.stored(slot); }
  link::StorageResult store(const link::StorageRequest& request) override { return host_.store(request); }

  /// Gathers what is written, so that a frame leaves in few pieces.
  void take(const std::uint8_t* bytes, std::size_t size);

 private:
  bool receive();
  void flush();

  Channel& channel_;
  Host& host_;
  bool greeted_ = false;
  std::uint32_t began_ = 0, late_steps_ = 0;
  std::array<std::uint8_t, kHead + kLongestRequest + kTail> in_ = {};
  std::size_t in_size_ = 0, used_ = 0;  // received; of them the frame in hand
  std::array<std::uint8_t, 1024> out_ = {};
  std::size_t out_size_ = 0;
  std::array<link::Datagram, kMostDatagrams> rx_ = {};
};

}  // namespace halfroll::hil
