#include "stream/references.hpp"

#include <algorithm>
#include <cmath>

#include "core/quaternion.hpp"

namespace halfroll::stream {
namespace {

constexpr double kGravityPlanned = 9.81;  // [m/s²], the planner's
const Vec3d kUp = Vec3d::UnitZ();

Vec3d vector(const Row3& row) { return {row[0], row[1], row[2]}; }
Vec3d place(const std::array<double, 4>& row) { return {row[0], row[1], row[2]}; }
Vec3 single(const Vec3d& v) { return v.cast<float>(); }

/// e of gain e - w x e = b: (gain² b + gain w x b + w (w b)) / (gain (gain² + w²)).
Vec3d without_turning(double gain, const Vec3d& w, const Vec3d& b) {
  const double along = w.dot(b), share = 1.0 / (gain * (gain * gain + w.squaredNorm()));
  return share * (gain * (gain * b + w.cross(b)) + w * along);
}

/// Turns unit vector a onto b the shortest way; not for opposite ones.
Quat least_turn(const Vec3d& a, const Vec3d& b) {
  const Vec3d cross = a.cross(b);
  Eigen::Vector4d q(1.0 + a.dot(b), cross.x(), cross.y(), cross.z());
  q /= q.norm();
  return {static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2]), static_cast<float>(q[3])};
}

Quat about_up(double yaw) {
  return {static_cast<float>(std::cos(yaw / 2.0)), 0.F, 0.F, static_cast<float>(std::sin(yaw / 2.0))};
}

FlatReference flat(const Derivatives& d) {
  FlatReference reference;
  reference.position = single(place(d[0]));
  reference.velocity = single(place(d[1]));
  reference.acceleration = single(place(d[2]));
  reference.jerk = single(place(d[3]));
  reference.snap = single(place(d[4]));
  reference.yaw = static_cast<float>(d[0][3]);
  reference.yaw_rate = static_cast<float>(d[1][3]);
  reference.yaw_acceleration = static_cast<float>(d[2][3]);
  return reference;
}

}  // namespace

Leads Leads::of(const Params& params, double link_delay, double rotor_delay) {
  const double lead = params.actuator_lead, delay = std::min(rotor_delay, lead);
  const double rate_gain = 2.0 * double{params.att_damping} * double{params.att_natural_frequency};
  return {link_delay + kTick / 2.0, rate_gain, delay, lead - delay};
}

Vec3d Leads::acceleration(const Path& path, double t) const {
  const Derivatives at = path.at(t + mid_age + delay);
  return place(at[2]) + lag * place(at[3]);
}

Vec3d Leads::rate_ahead(const Path& path, double t) const {
  const double middle = t + mid_age;
  const double begin = middle + delay - kTick / 2.0, end = middle + delay + kTick / 2.0;
  const Vec3d speed_up = vector(path.rate_at(end)) - vector(path.rate_at(begin));
  const Vec3d further = vector(path.rate_change_at(end)) - vector(path.rate_change_at(begin));
  const Vec3d w = vector(path.rate_at(middle));
  return w - vector(path.rate_at(t)) + without_turning(rate_gain, w, (speed_up + lag * further) / kTick);
}

Derivatives nose_led(const Derivatives& planned, double rate, const Setpoint& tried) {
  const Vec3d force = place(planned[2]) + Vec3d(0.0, 0.0, kGravityPlanned);
  const Vec3d axis = force / force.norm();
  const Quat q_planned = least_turn(kUp, axis) * about_up(planned[0][3]);
  const Vec3d tried_axis = rotate(tried.q_WD, Vec3(Vec3::UnitZ())).cast<double>();
  const Quat q_wanted = least_turn(axis, tried_axis) * q_planned;
  const Quat turn = conj(least_turn(kUp, tried_axis)) * q_wanted;
  Derivatives led = planned;
  led[0][3] = 2.0 * std::atan2(double{turn.z}, double{turn.w});
  led[1][3] += rate - double{tried.w_WD_D.z()};
  return led;
}

Setpoint References::setpoint(const Path& path, std::uint64_t start_us, std::uint64_t t_us, const Estimate& state) {
  const double t = static_cast<double>(static_cast<std::int64_t>(t_us - start_us)) * 1e-6;
  const Derivatives planned = path.at(t);
  OuterLoopInput in;
  in.t_us = t_us;
  in.state = state;
  in.lead_acceleration = single(leads_.acceleration(path, t));
  in.mid_age = static_cast<float>(leads_.mid_age);
  in.sigma = static_cast<float>(path.sigma_at(t));
  in.sigma_event_near = path.is_near_sigma_event(t);
  in.at_sample = in.now = flat(planned);  // telemetry is the estimate for its own stamp, the tick
  if (path.leads_nose_at(t)) {
    OuterLoop trial = loop_;
    const Setpoint tried = trial.step(in, params_);
    in.at_sample = in.now = flat(nose_led(planned, path.rate_at(t)[2], tried));
  }
  in.lead_rate = single(leads_.rate_ahead(path, t));
  return loop_.step(in, params_);
}

}  // namespace halfroll::stream
