// What a board writes down when it falls, and reads when it has started again. Why: a fault in flight leaves nothing
// else. The record is in RAM that no start clears.
#pragma once
#include <cstdint>

#include "link/messages.hpp"

namespace halfroll::cortex_m {

enum class Fall : std::uint32_t { kFault = 1, kWatchdog = 2, kAbort = 3 };

struct CrashRecord {
  std::uint32_t magic = 0;
  Fall fall = Fall::kFault;
  std::uint32_t address = 0;  // of the instruction
  std::uint32_t status = 0;   // configurable fault status register
  std::uint32_t checksum = 0;
};

/// Write it down and start the board again.
[[noreturn]] void fall(Fall why, std::uint32_t address);

/// What the board before this start left, in words, once: empty if it was switched off in peace.
link::Text<50> take_last_words();

}  // namespace halfroll::cortex_m
