#include "core/rotor_monitor.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"

namespace halfroll {
namespace {

constexpr float kFilterTime = 0.05F;  // [s]: gyro noise of 0.01 rad/s becomes 0.2 rad/s², a few mN of rotor thrust
constexpr float kFilterShare = kDt / (kFilterTime + kDt);

float lag_share(float lag) { return kDt / (lag + kDt); }

}  // namespace

void RotorMonitor::step(const RotorCommands& given, const Vec3& w_WB_B, const Vec3& specific_force_B,
                        const Vehicle& vehicle) {
  const bool fixed_pitch = vehicle.rotor_kind == RotorKind::kFixedPitch;
  const auto lagged = [&](float thrust) { return fixed_pitch ? std::sqrt(std::max(thrust, 0.F)) : thrust; };
  const auto thrust_of = [&](float state) { return fixed_pitch ? state * state : state; };
  const Vec3 momentum = vehicle.inertia.cwiseProduct(w_WB_B);
  if (!started_) {
    started_ = true;
    rate_ = w_WB_B;
    gyroscopic_ = w_WB_B.cross(momentum);
    force_ = vehicle.mass * specific_force_B.z();
    for (std::size_t i = 0; i < 4; ++i) {
      expected_[i] = lagged(given.thrust[i]);
      filtered_[i] = given.thrust[i];
    }
  }
  const Vec3 acceleration = (w_WB_B - rate_) / kFilterTime;  // the filter's own slope: differentiated and filtered
  rate_ += kFilterShare * (w_WB_B - rate_);
  gyroscopic_ += kFilterShare * (w_WB_B.cross(momentum) - gyroscopic_);
  force_ += kFilterShare * (vehicle.mass * specific_force_B.z() - force_);

  const Vec3 torque = vehicle.inertia.cwiseProduct(acceleration) + gyroscopic_;
  const float u = torque.x() / vehicle.arm, v = torque.y() / vehicle.arm, y = torque.z() / vehicle.yaw_coefficient;
  const float sum13 = 0.5F * (force_ - y), sum24 = 0.5F * (force_ + y);  // as the mixer has it
  const std::array<float, 4> gives = {0.5F * (sum13 + u), 0.5F * (sum24 + v), 0.5F * (sum13 - u), 0.5F * (sum24 - v)};
  const float share_up = lag_share(vehicle.rotor_lag), share_down = lag_share(vehicle.rotor_lag_down);
  for (std::size_t i = 0; i < 4; ++i) {
    const float wanted = lagged(given.thrust[i]);
    expected_[i] += (fixed_pitch && wanted < expected_[i] ? share_down : share_up) * (wanted - expected_[i]);
    filtered_[i] += kFilterShare * (thrust_of(expected_[i]) - filtered_[i]);
    error_[i] = filtered_[i] - gives[i];
  }
}

int RotorMonitor::suspect(const Vehicle& vehicle, const Params& params) const {
  const float hover = 0.25F * vehicle.mass * kGravity;
  std::size_t worst = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (std::abs(error_[i]) > std::abs(error_[worst])) worst = i;
  }
  float next = 0.F;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i != worst) next = std::max(next, std::abs(error_[i]));
  }
  const float size = std::abs(error_[worst]);
  const bool off = params.rotor_fault_share > 0.F && size > params.rotor_fault_share * hover && size > 2.F * next;
  return off ? static_cast<int>(worst) + 1 : 0;
}

}  // namespace halfroll
