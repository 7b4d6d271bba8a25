// How kind the world is: noise, delay, drag. Why: the same flight is flown in a perfect world to see the method, and
// in an ordinary one to see what it is worth.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace halfroll::sim {

/// Standard deviations are per axis and sample. The default is the perfect world, `ideal`.
struct Scenario {
  bool drag = false;
  double gyro_noise = 0.0;               // [rad/s]
  double accelerometer_noise = 0.0;      // [m/s²]
  double position_noise = 0.0;           // [m], motion capture
  double attitude_noise = 0.0;           // [rad], motion capture, white
  double attitude_wander = 0.0;          // [rad], motion capture, slow
  double attitude_wander_time = 0.5;     // [s], correlation time of the slow part
  std::uint64_t pose_period_us = 10000;  // motion capture at 100 Hz
  std::uint64_t pose_delay_us = 0;       // from exposure to delivery, less than 8 periods
};

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;
inline constexpr Scenario kIdeal = {};

/// Noise and delay of a motion-capture laboratory.
inline constexpr Scenario kNominal = [] {
  Scenario s;
  s.drag = true;
  s.gyro_noise = 0.01;
  s.accelerometer_noise = 0.1;
  s.position_noise = 0.001;
  s.attitude_noise = 0.03 * kDegree;
  s.attitude_wander = 0.2 * kDegree;
  s.pose_delay_us = 10000;
  return s;
}();

/// "ideal", "nominal"; nothing for any other name.
inline std::optional<Scenario> find_scenario(std::string_view name) {
  if (name == "ideal") return kIdeal;
  if (name == "nominal") return kNominal;
  return std::nullopt;
}

}  // namespace halfroll::sim
