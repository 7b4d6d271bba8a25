#include "boards/cortex_m/clock.hpp"

#include "boards/cortex_m/crash_record.hpp"
#include "boards/cortex_m/registers.hpp"

namespace halfroll::cortex_m::clock {
namespace {

constexpr std::uint32_t kWatchdogTicks = 100 * kTicksPerStep;
constexpr unsigned kWatchdogLine = 8;  // CMSDK timer 0: the MPS2 images have no watchdog that QEMU knows
constexpr std::uint32_t kTimerOn = 9;  // interrupt, enabled
constexpr std::uint8_t kTickUrgency = 0x80;
constexpr std::uint32_t kTickPending = 1U << 26U;

Timer& watchdog() { return *reinterpret_cast<Timer*>(0x40000000U); }

volatile std::uint32_t milliseconds = 0;

}  // namespace

void start() {
  systick::reload() = kTicksPerStep - 1;
  systick::count() = 0;
  systick::control() = systick::kOn;
  *reinterpret_cast<volatile std::uint8_t*>(0xE000ED23U) = kTickUrgency;
  nvic::priority(kWatchdogLine, 0);
  nvic::enable(kWatchdogLine);
  watchdog().reload = kWatchdogTicks;
  watchdog().value = kWatchdogTicks;
  watchdog().control = kTimerOn;
}

void feed_watchdog() { watchdog().value = kWatchdogTicks; }

std::uint32_t ticks() {
  for (;;) {
    const std::uint32_t before = milliseconds, left = systick::count();
    if (before == milliseconds && (scb::interrupt_control() & kTickPending) == 0) {
      return before * kTicksPerStep + (kTicksPerStep - 1 - left);
    }
  }
}

}  // namespace halfroll::cortex_m::clock

extern "C" {
void tick_interrupt();
void watchdog_interrupt();
[[noreturn]] void record_hang(const std::uint32_t* stacked);

void tick_interrupt() { halfroll::cortex_m::clock::milliseconds = halfroll::cortex_m::clock::milliseconds + 1; }

[[gnu::naked]] void watchdog_interrupt() {
  asm volatile(
      "tst lr, #4\n"
      "ite eq\n"
      "mrseq r0, msp\n"
      "mrsne r0, psp\n"
      "b record_hang\n");
}

void record_hang(const std::uint32_t* stacked) {
  halfroll::cortex_m::fall(halfroll::cortex_m::Fall::kWatchdog, stacked[6]);
}
}
