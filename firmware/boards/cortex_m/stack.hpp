// How deep the stack has ever been. Why: what overflows it is found in flight otherwise.
#pragma once
#include <cstdint>

namespace halfroll::cortex_m {

inline constexpr std::uint32_t kStackPaint = 0xA5A5A5A5U;

/// [bytes] since power-on, from the paint that is left.
std::uint32_t stack_used();

}  // namespace halfroll::cortex_m
