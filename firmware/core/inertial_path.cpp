#include "core/inertial_path.hpp"

#include <algorithm>

#include "core/quaternion.hpp"

namespace halfroll {
namespace {

/// What holds a body up: the specific force of one that stands [m/s²].
Vec3 up() { return {0.F, 0.F, kGravity}; }

float seconds(std::uint64_t us) { return 1e-6F * static_cast<float>(us); }

/// The motion `seconds` before `end`, from what the specific force did in between.
Motion before(const Motion& end, const Quat& q_start, const Vec3& faster_W, const Vec3& moved_W, float dt) {
  Motion start;
  start.q_WB = q_start;
  start.v_WB = end.v_WB - faster_W + dt * up();
  start.p_WB = end.p_WB - dt * start.v_WB - moved_W + 0.5F * dt * dt * up();
  return start;
}

/// Between two motions dt apart, as if rate and acceleration were constant.
Motion between(const Motion& start, const Motion& end, float share, float dt) {
  Motion m;
  m.q_WB = start.q_WB * from_rotation_vector(share * rotation_vector(conj(start.q_WB) * end.q_WB));
  m.v_WB = start.v_WB + share * (end.v_WB - start.v_WB);
  m.p_WB = start.p_WB + share * (dt * start.v_WB + share * (end.p_WB - start.p_WB - dt * start.v_WB));
  return m;
}

}  // namespace

void InertialPath::step(std::uint64_t t_us, const Imu& before, const Imu& imu, bool travelling) {
  const Vec3 w = 0.5F * (before.w_WB_B + imu.w_WB_B);
  const Quat q_WB = normalised(now_.q_WB * from_rotation_vector(w * kDt));
  const Vec3 f_W = 0.5F * (rotate(now_.q_WB, before.specific_force_B) + rotate(q_WB, imu.specific_force_B));
  begun_.moved_W += kDt * (begun_.faster_W + 0.5F * kDt * f_W);
  begun_.faster_W += kDt * f_W;
  if (travelling) {
    const Vec3 a = f_W - up();
    now_.p_WB += kDt * (now_.v_WB + 0.5F * kDt * a);
    now_.v_WB += kDt * a;
  }
  now_.q_WB = q_WB;
  t_us_ = t_us;
  if (t_us % kStrideUs != 0) return;
  Stride& stride = steps_[t_us / kStrideUs % kStrides];
  const Quat q_BW = conj(begun_.q_WB);
  stride = {q_BW * q_WB, rotate(q_BW, begun_.faster_W), rotate(q_BW, begun_.moved_W)};
  remembered_ = std::min<std::uint32_t>(remembered_ + 1, kStrides - 2);
  begun_ = {t_us, q_WB, Vec3::Zero(), Vec3::Zero()};
}

std::optional<Motion> InertialPath::at(std::uint64_t t_us) const {
  if (t_us > t_us_) return std::nullopt;
  Motion end = now_;
  std::uint64_t end_us = t_us_, start_us = begun_.since_us;
  Motion start = before(end, begun_.q_WB, begun_.faster_W, begun_.moved_W, seconds(end_us - start_us));
  for (std::uint32_t left = remembered_; start_us > t_us; --left) {
    if (left == 0) return std::nullopt;
    end = start;
    end_us = start_us;
    const Stride& stride = steps_[end_us / kStrideUs % kStrides];
    const Quat q_WB = end.q_WB * conj(stride.turn);  // of unit length to 1e-6 after as many as are remembered
    start = before(end, q_WB, rotate(q_WB, stride.faster), rotate(q_WB, stride.moved), seconds(kStrideUs));
    start_us -= kStrideUs;
  }
  if (t_us == end_us) return end;
  if (t_us == start_us) return start;
  const float dt = seconds(end_us - start_us);
  return between(start, end, seconds(t_us - start_us) / dt, dt);
}

void InertialPath::correct(const Vec3& turn_W, const Vec3& faster_W, const Vec3& moved_W) {
  const Quat turn = from_rotation_vector(turn_W);
  now_.q_WB = normalised(turn * now_.q_WB);
  now_.v_WB += faster_W;
  now_.p_WB += moved_W;
  begun_.q_WB = normalised(turn * begun_.q_WB);  // what happened since is at most a stride: not turned
}

void InertialPath::pin(std::uint64_t t_us, const Motion& then) {
  const Motion was = at(t_us).value_or(now_);
  const float age = t_us < t_us_ ? seconds(t_us_ - t_us) : 0.F;
  const Quat turn = normalised(then.q_WB * conj(was.q_WB));
  const Vec3 faster_W = now_.v_WB - was.v_WB + age * up();
  const Vec3 moved_W = now_.p_WB - was.p_WB - age * was.v_WB + 0.5F * age * age * up();
  now_.q_WB = normalised(turn * now_.q_WB);
  now_.v_WB = then.v_WB + rotate(turn, faster_W) - age * up();
  now_.p_WB = then.p_WB + age * then.v_WB + rotate(turn, moved_W) - 0.5F * age * age * up();
  begun_.q_WB = normalised(turn * begun_.q_WB);
  begun_.faster_W = rotate(turn, begun_.faster_W);
  begun_.moved_W = rotate(turn, begun_.moved_W);
}

}  // namespace halfroll
