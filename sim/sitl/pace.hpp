// Vehicle time against the wall clock. Why: people and their ground stations live in real time; a computer that falls
// behind shall fly late, not fast.
#pragma once
#include <cstdint>

#include "boards/host/steady_clock.hpp"

namespace halfroll::sitl {

class Pace {
 public:
  /// `speed` times real time; 0 is as fast as it goes.
  explicit Pace(double speed) : us_per_step_(speed > 0.0 ? 1000.0 / speed : 0.0) { restart(); }

  /// Begin counting now: time that the vehicle stood is not made up for.
  void restart() {
    start_us_ = host::wall_us();
    steps_ = 0;
  }

  /// Sleep until the next step is due; a signal may end it early.
  void wait() {
    if (us_per_step_ == 0.0) return;
    const std::uint64_t due_us = start_us_ + static_cast<std::uint64_t>(us_per_step_ * static_cast<double>(steps_++));
    const std::uint64_t now_us = host::wall_us();
    if (due_us > now_us) {
      host::sleep_until(due_us);
    } else if (now_us - due_us > kLatestUs) {
      restart();
    }
  }

 private:
  static constexpr std::uint64_t kLatestUs = 50000;  // what is made up for after a pause of the machine
  double us_per_step_;
  std::uint64_t start_us_ = 0, steps_ = 0;
};

}  // namespace halfroll::sitl
