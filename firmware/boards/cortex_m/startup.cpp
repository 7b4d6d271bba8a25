// From power-on to board_main: vector table, memory, FPU; and what stands where a C library expects an operating
// system.
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "boards/cortex_m/crash_record.hpp"
#include "boards/cortex_m/registers.hpp"
#include "boards/cortex_m/stack.hpp"

void board_main();

extern "C" {
extern std::uint32_t stack_top[], stack_bottom[];  // linker script
extern std::uint8_t data_load[], data_begin[], data_end[], bss_begin[], bss_end[];
extern void (*init_begin[])();
extern void (*init_end[])();

void tick_interrupt();
void watchdog_interrupt();
void uart_receive_interrupt();
void uart_transmit_interrupt();
[[noreturn]] void reset();
void fault();
[[noreturn]] void record_fault(const std::uint32_t* stacked);
[[noreturn]] void abort();
[[noreturn]] void __cxa_pure_virtual();
void* __dso_handle = nullptr;
}

using halfroll::cortex_m::Fall;

namespace {

constexpr std::uint32_t kPaint = halfroll::cortex_m::kStackPaint;

struct Vectors {
  const void* stack;
  void (*exceptions[15])();
  void (*interrupts[16])();
};

[[gnu::section(".vectors"), gnu::used]] const Vectors vectors = {
    stack_top,
    {reset, fault, fault, fault, fault, fault, nullptr, nullptr, nullptr, nullptr, fault, fault, nullptr, fault,
     tick_interrupt},
    {uart_receive_interrupt, uart_transmit_interrupt, fault, fault, fault, fault, fault, fault, watchdog_interrupt,
     fault, fault, fault, fault, fault, fault, fault}};

}  // namespace

extern "C" {

[[gnu::noinline]] static void start() {
  std::memcpy(data_begin, data_load, static_cast<std::size_t>(data_end - data_begin));
  std::memset(bss_begin, 0, static_cast<std::size_t>(bss_end - bss_begin));
  for (auto* init = init_begin; init != init_end; ++init) (*init)();
  board_main();
}

void reset() {
  halfroll::cortex_m::scb::coprocessors() |= 0xFU << 20U;  // the FPU
  asm volatile("dsb\nisb" ::: "memory");
  const auto* here = static_cast<const std::uint32_t*>(__builtin_frame_address(0));
  for (volatile std::uint32_t* word = stack_bottom; word < here - 16; ++word) *word = kPaint;
  start();
  for (;;) {
  }
}

/// The stacked program counter tells where it fell.
[[gnu::naked]] void fault() {
  asm volatile(
      "tst lr, #4\n"
      "ite eq\n"
      "mrseq r0, msp\n"
      "mrsne r0, psp\n"
      "b record_fault\n");
}

void record_fault(const std::uint32_t* stacked) { halfroll::cortex_m::fall(Fall::kFault, stacked[6]); }

void abort() { halfroll::cortex_m::fall(Fall::kAbort, reinterpret_cast<std::uint32_t>(__builtin_return_address(0))); }

void __cxa_pure_virtual() { abort(); }
}

namespace halfroll::cortex_m {

std::uint32_t stack_used() {
  const std::uint32_t* word = stack_bottom;
  while (word < stack_top && *word == kPaint) ++word;
  return static_cast<std::uint32_t>((stack_top - word) * 4);
}

}  // namespace halfroll::cortex_m
