// The few registers that are touched: the processor's own (Armv7-M) and those of Arm's CMSDK peripherals.
#pragma once
#include <cstdint>

namespace halfroll::cortex_m {

inline volatile std::uint32_t& at(std::uint32_t address) { return *reinterpret_cast<volatile std::uint32_t*>(address); }

namespace systick {
inline volatile std::uint32_t& control() { return at(0xE000E010U); }
inline volatile std::uint32_t& reload() { return at(0xE000E014U); }
inline volatile std::uint32_t& count() { return at(0xE000E018U); }  // downwards
inline constexpr std::uint32_t kOn = 7;                             // processor clock, interrupt, enabled
}  // namespace systick

namespace nvic {
inline void enable(unsigned line) { at(0xE000E100U) = 1U << line; }
inline void priority(unsigned line, std::uint8_t urgency) {  // 0 is the most urgent
  reinterpret_cast<volatile std::uint8_t*>(0xE000E400U)[line] = urgency;
}
}  // namespace nvic

namespace scb {
inline volatile std::uint32_t& interrupt_control() { return at(0xE000ED04U); }
inline volatile std::uint32_t& reset_control() { return at(0xE000ED0CU); }
inline volatile std::uint32_t& fault_status() { return at(0xE000ED28U); }
inline volatile std::uint32_t& coprocessors() { return at(0xE000ED88U); }
}  // namespace scb

/// A CMSDK timer: counts down at the bus clock, interrupts at zero, begins again at `reload`.
struct Timer {
  volatile std::uint32_t control, value, reload, interrupt;
};
/// A CMSDK UART.
struct UartRegisters {
  volatile std::uint32_t data, state, control, interrupt, divider;
};

}  // namespace halfroll::cortex_m
