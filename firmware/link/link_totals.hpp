// What a link has carried, as telemetry shows it. Why: a bad radio, a flood or a forger must be seen, not guessed.
#pragma once
#include <cstdint>

namespace halfroll::link {

/// Since boot.
struct LinkTotals {
  std::uint32_t received = 0;     // good frames
  std::uint32_t lost = 0;         // frames missing between two good ones of one sender
  std::uint32_t bad = 0;          // frames with a wrong checksum
  std::uint32_t refused = 0;      // frames that signing did not admit
  std::uint32_t passed_over = 0;  // [bytes] beyond what a step reads
};

}  // namespace halfroll::link
