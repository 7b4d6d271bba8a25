// What holds after every step, whatever came in. Why: a fuzzer finds what breaks; this says that something did.
#pragma once
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "autopilot.hpp"

namespace halfroll::fuzz {

[[noreturn]] inline void fail(const char* what, std::uint64_t t_us) {
  std::fprintf(stderr, "invariant broken at %.3f s: %s\n", 1e-6 * static_cast<double>(t_us), what);
  std::abort();
}

inline bool is_unit(const Quat& q) {
  const float norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::fabs(norm2 - 1.F) < 1e-3F;  // false for NaN
}

inline void check_frames(const LinkOutputs& out, std::uint64_t t_us) {
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (frame.size < 12 || frame.size > frame.bytes.size()) fail("a frame is no MAVLink frame", t_us);
    if (frame.bytes[0] != 0xFD || frame.to.link >= link::kLinkCount) fail("a frame goes nowhere", t_us);
  }
}

/// After Autopilot::step.
inline void check_step(const Autopilot& autopilot, const Outputs& out, const Vehicle& vehicle, std::uint64_t due_us) {
  const std::uint64_t t_us = autopilot.t_us();
  if (t_us != due_us) fail("time is not the count of steps", t_us);
  for (const float thrust : out.rotors.thrust) {
    if (!(thrust >= vehicle.thrust_min && thrust <= vehicle.thrust_max))
      fail("a rotor command outside its limits", t_us);
  }
  const Estimate& estimate = autopilot.estimate();
  if (!is_unit(estimate.q_WB)) fail("the attitude is no unit quaternion", t_us);
  if (!estimate.p_WB.allFinite() || !estimate.v_WB.allFinite() || !estimate.w_WB_B.allFinite()) {
    fail("the estimate is not finite", t_us);
  }
  const Reference& reference = autopilot.reference();
  if (!is_unit(reference.q_WD)) fail("the reference attitude is no unit quaternion", t_us);
  if (!reference.w_WD_D.allFinite() || !reference.dw_WD_D.allFinite() || !std::isfinite(reference.thrust)) {
    fail("the reference is not finite", t_us);
  }
  const Params& params = autopilot.params();
  for (const ParamInfo& info : kParamTable) {
    const float value = params.*info.member;
    if (!(value >= info.least && value <= info.most)) fail(info.id, t_us);
  }
  check_frames(out.link, t_us);
}

}  // namespace halfroll::fuzz
