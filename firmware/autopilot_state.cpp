// All that the autopilot remembers, compared, counted, and looked at for what must never be in it.
#include <cmath>
#include <cstring>

#include "autopilot.hpp"
#include "core/quaternion.hpp"
#include "core/state_checksum.hpp"

namespace halfroll {
namespace {

constexpr float kUnit = 1e-3F;  // how far a unit quaternion's square may be from 1

bool is_unit(const Quat& q) { return std::abs(dot(q, q) - 1.F) < kUnit; }  // false for NaN

/// Whether every float that it visits is a number.
struct AllFinite {
  bool so = true;
  template <class T>
  void operator()(const T& x) {
    if constexpr (std::is_same_v<T, float>) so = so && std::isfinite(x);
  }
};

}  // namespace

/// Everything that decides future commands. Wall-clock pacing and received bytes of half frames are not in it.
auto Autopilot::state() const {
  return std::tuple_cat(
      std::tie(t_us_, mode_, user_mode_, armed_, flown_, terminated_, entered_by_ground_station_, idle_s_,
               failsafe_until_us_, ground_heard_us_, imu_failed_us_, hold_position_, hold_yaw_, stopping_, recovery_,
               takeoff_height_, inverted_, return_climbing_, mission_started_, mission_revision_, offboard_stage_,
               position_was_valid_, position_resets_),
      std::tie(setpoint_.t_us, setpoint_.q_WD, setpoint_.w_WD_D, setpoint_.thrust, setpoint_.attitude_used,
               setpoint_.rate_used, setpoint_mask_, reference_.thrust, rotors_, origin_, home_, home_chosen_),
      pose_source_.state(), estimator_.state(), landed_.state(), follower_.state(), runner_.state(), offboard_.state(),
      outer_loop_.state(), rotor_lag_inverse_.state(), failsafes_.state(), rotor_monitor_.state(), manoeuvre_.state());
}

bool Autopilot::same_state(const Autopilot& other) const {
  return state() == other.state() && missions_ == other.missions_ &&
         std::memcmp(&params_, &other.params_, sizeof params_) == 0;  // all floats, no padding
}

std::uint32_t Autopilot::state_checksum() const {
  StateChecksum checksum;
  checksum.add(state());
  checksum.add(missions_.id());
  for (const ParamInfo& row : kParamTable) checksum.add(params_.*row.member);
  return checksum.value();
}

const char* Autopilot::broken_invariant() const {
  for (const float thrust : rotors_.thrust) {
    const bool off = !armed_ && thrust == 0.F;
    if (!off && !(thrust >= vehicle_.thrust_min && thrust <= vehicle_.thrust_max))
      return "a rotor command outside its limits";
  }
  if (!is_unit(estimate_.q_WB)) return "the attitude is no unit quaternion";
  if (!is_unit(reference_.q_WD)) return "the reference attitude is no unit quaternion";
  if (!is_unit(setpoint_.q_WD)) return "the setpoint attitude is no unit quaternion";
  AllFinite finite;
  each_value(state(), finite);
  each_value(std::tie(estimate_.w_WB_B, estimate_.p_WB, estimate_.v_WB, reference_.w_WD_D, reference_.dw_WD_D), finite);
  if (!finite.so) return "something remembered is not finite";
  if (!(outer_loop_.integral().cwiseAbs().maxCoeff() <= OuterLoop::kMostIntegral)) return "an integral out of bounds";
  for (const ParamInfo& info : kParamTable) {
    const float value = params_.*info.member;
    if (!(value >= info.least && value <= info.most)) return info.id;
  }
  return nullptr;
}

}  // namespace halfroll
