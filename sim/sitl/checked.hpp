// What must hold after every step of an autopilot. Why: a fuzzer, a test or a sanitizer finds what breaks; this says
// that something did, in one place for all of them.
#pragma once
#include <cstdio>
#include <cstdlib>

#include "autopilot.hpp"

namespace halfroll::sitl {

/// Builds under sanitizers and for debugging look after each step, others never.
#ifdef HALFROLL_CHECKED
inline constexpr bool kChecked = true;
#else
inline constexpr bool kChecked = false;
#endif

[[noreturn]] inline void fail(const char* what, std::uint64_t t_us) {
  std::fprintf(stderr, "invariant broken at %.3f s: %s\n", 1e-6 * static_cast<double>(t_us), what);
  std::abort();
}

inline const char* broken_frame(const LinkOutputs& out) {
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (frame.size < 12 || frame.size > frame.bytes.size()) return "a frame is no MAVLink frame";
    if (frame.bytes[0] != 0xFD || frame.to.link >= link::kLinkCount) return "a frame goes nowhere";
  }
  return nullptr;
}

/// Autopilot::step, and an end with words if anything is broken after it.
inline Outputs checked_step(Autopilot& autopilot, const Inputs& in) {
  const std::uint64_t before_us = autopilot.t_us();
  const Outputs out = autopilot.step(in);
  const std::uint64_t t_us = autopilot.t_us();
  const bool first = before_us == 0 && t_us == 0;
  if (!first && t_us != before_us + kStepUs) fail("time is not the count of steps", t_us);
  if (const char* what = autopilot.broken_invariant()) fail(what, t_us);
  if (const char* what = broken_frame(out.link)) fail(what, t_us);
  return out;
}

/// The same, checked in the builds that check.
inline Outputs step(Autopilot& autopilot, const Inputs& in) {
  return kChecked ? checked_step(autopilot, in) : autopilot.step(in);
}

}  // namespace halfroll::sitl
