// Attitude law (Eqs 20-22, corrected). Why: one controller for hover, flips and inverted flight.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"

namespace halfroll {

/// Wrench turning the body onto its reference; thrust passes through.
/// M = sgn(q_e0) Kp qv_e - Kd (w - R_e w_d) + w x J w + J (R_e dw_d - w x R_e w_d),  q_e = q* q_d.
/// Torque [N·m] in body axes, not yet limited (mixer.hpp limits).
Wrench attitude_wrench(const Quat& q_WB, const Vec3& w_WB_B, const Reference& reference, const Vehicle& vehicle,
                       const Params& params);

}  // namespace halfroll
