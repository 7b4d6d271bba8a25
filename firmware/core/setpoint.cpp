#include "core/setpoint.hpp"

#include <algorithm>

#include "core/quaternion.hpp"

namespace halfroll {
namespace {

constexpr std::int64_t kMostAheadUs = 100000;

/// Time since the setpoint was meant [s]; negative for a stamp slightly in the future.
float age(const Setpoint& setpoint, std::uint64_t t_us) {
  const std::int64_t age_us = static_cast<std::int64_t>(t_us) - static_cast<std::int64_t>(setpoint.t_us);
  return 1e-6F * static_cast<float>(std::clamp(age_us, -kMostAheadUs, kMostAheadUs));
}

}  // namespace

Reference extrapolate(const Setpoint& setpoint, const Estimate& estimate, std::uint64_t t_us, const Params& params) {
  Vec3 w = setpoint.w_WD_D, dw = setpoint.dw_WD_D;
  for (int axis = 0; axis < 3; ++axis) {
    if (!setpoint.rate_used[static_cast<std::size_t>(axis)]) w[axis] = dw[axis] = 0.F;
  }
  if (!setpoint.attitude_used) return {estimate.q_WB, w, dw, setpoint.thrust};

  const float h = params.reference_extrapolation == 0.F ? 0.F : age(setpoint, t_us);
  Reference reference;
  reference.q_WD = setpoint.q_WD * from_rotation_vector((w + 0.5F * h * dw) * h);  // a unit's to the last bits
  reference.w_WD_D = w + h * dw;
  reference.dw_WD_D = dw;
  reference.thrust = setpoint.thrust * up_axis(reference.q_WD).dot(up_axis(estimate.q_WB));
  return reference;
}

}  // namespace halfroll
