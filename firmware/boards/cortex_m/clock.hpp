// The 1 kHz tick, and the watchdog that sees to it that the loop goes round.
#pragma once
#include <cstdint>

namespace halfroll::cortex_m::clock {

inline constexpr std::uint32_t kTicksPerStep = 25000;  // of the 25 MHz clock

/// SysTick at 1 kHz; the watchdog bites when it is not fed for 100 ms.
void start();
void feed_watchdog();

/// Ticks of the 25 MHz clock since start(); wraps.
std::uint32_t ticks();

}  // namespace halfroll::cortex_m::clock
