// Between two setpoints. Why: at 1000 deg/s a reference held for 10 ms is a stair of 10 deg.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

/// The setpoint turned by its own rates to `t_us` (at most 0.1 s ahead), its thrust projected on the actual body axis:
/// T = thrust (R(q_d) e3).(R(q) e3)  [Eq 14]. Without attitude the reference is where the body points, so that only
/// rates are controlled, and the thrust is not projected. A rate left open is 0, not the actual one: the attitude loop
/// lives on damping against it, and without attitude a body that nobody commands must stop turning, not drift.
/// With REF_EXTRAP = 0 the attitude is held. A stamp in the future turns it back.
Reference extrapolate(const Setpoint& setpoint, const Estimate& estimate, std::uint64_t t_us, const Params& params);

}  // namespace halfroll
