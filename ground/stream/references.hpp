// References: path and measured state become one setpoint a tick (100 Hz), by the outer loop that is on board too.
// Why: three fields of SET_ATTITUDE_TARGET are taken from three moments of the path, each lead removing one lag between
// here and the rotors. This is the only place that knows the leads; ground station and simulated flights share it.
#pragma once
#include <Eigen/Core>

#include "core/outer_loop.hpp"
#include "stream/path.hpp"

namespace halfroll::stream {

inline constexpr double kTick = 0.010;  // [s], one setpoint each
inline constexpr std::uint64_t kTickUs = 10000;

using Vec3d = Eigen::Vector3d;

/// How far ahead of the tick each field is taken [s]; the attitude is taken at the tick itself.
struct Leads {
  double mid_age = 0.0;    // mean age of a setpoint while it is in use
  double rate_gain = 0.0;  // of the attitude loop, Kd/J [1/s]
  double delay = 0.0;      // dead time of the rotors
  double lag = 0.0;        // first-order, of their thrusts

  /// params: the autopilot's; link_delay: what the wire is believed to take [s], 0 in lockstep.
  /// The rate leads by the attitude loop's own lag J/Kd, the thrust by the rotors'.
  static Leads of(const Params& params, double link_delay, double rotor_delay);

  /// What the rotors are asked for so that, lagging, they give the path's acceleration.
  Vec3d acceleration(const Path& path, double t) const;
  /// What the rate sent at t is more than the path's at t: the path's while the setpoint is in use, and what makes the
  /// attitude law ask for the path's angular acceleration a, with what the rotors' lag needs.
  /// A rate w + e makes the law ask for J (rate_gain e - w x e), the second part from its -J w x w_d.
  Vec3d rate_ahead(const Path& path, double t) const;
};

/// `planned` with the yaw and yaw rate for which position feedback turns the planned attitude the shortest way to the
/// thrust axis of `tried`, at the planned body rate about it.
/// Near the horizon the yaw of one attitude, counted from upright, depends so strongly on where the thrust axis points
/// that feedback of a degree would turn the nose as far, with the little torque that rotors have for it.
Derivatives nose_led(const Derivatives& planned, double rate, const Setpoint& tried);

class References {
 public:
  /// params: the autopilot's gains.
  References(const Vehicle& vehicle, const Params& params, const Leads& leads)
      : loop_(vehicle), params_(params), leads_(leads) {}

  /// Forget what was flown before; continue from this attitude.
  void begin(const Quat& q_WB) { loop_.reset(q_WB); }

  /// What to send at the tick t_us of `state` when `path` began at start_us of vehicle time.
  Setpoint setpoint(const Path& path, std::uint64_t start_us, std::uint64_t t_us, const Estimate& state);

 private:
  OuterLoop loop_;
  Params params_;
  Leads leads_;
};

}  // namespace halfroll::stream
