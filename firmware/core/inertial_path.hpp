// Where the inertial sensors say the vehicle went: its motion now, and the steps that led here.
// Why: a late measurement must be compared with the instant at which it was taken. The steps are kept relative to each
// other, in body axes, so a correction of now is a correction of the whole path and nothing is rewritten.
#pragma once
#include <array>
#include <optional>

#include "core/constants.hpp"
#include "core/types.hpp"

namespace halfroll {

struct Motion {
  Quat q_WB;
  Vec3 v_WB = Vec3::Zero();
  Vec3 p_WB = Vec3::Zero();
  auto state() const { return std::tie(q_WB, v_WB, p_WB); }
  bool operator==(const Motion& o) const { return state() == o.state(); }
};

class InertialPath {
 public:
  static constexpr std::uint64_t kMemoryUs = 252000;  // how far back at() goes

  /// One millisecond on, to t_us. Trapezoids: the sample before and `imu`, both at the ends of the step, both without
  /// their biases. `travelling` false: only the attitude moves.
  void step(std::uint64_t t_us, const Imu& before, const Imu& imu, bool travelling);

  /// The motion at t_us as believed now; nothing if that is longer ago than it remembers, or ahead.
  std::optional<Motion> at(std::uint64_t t_us) const;
  const Motion& now() const { return now_; }
  std::uint64_t t_us() const { return t_us_; }

  /// Turn, hurry and shift what is believed of now: small, first order.
  void correct(const Vec3& turn_W, const Vec3& faster_W, const Vec3& moved_W);
  /// Move the whole path so that at t_us, an instant that at() knows, the motion was `then`.
  void pin(std::uint64_t t_us, const Motion& then);

  auto state() const { return std::tie(now_, t_us_, remembered_, steps_, begun_); }

 private:
  static constexpr std::uint64_t kStrideUs = 2 * kStepUs;
  static constexpr std::size_t kStrides = 128;

  /// A stride seen from its beginning, without gravity: turn, and what the specific force added.
  struct Stride {
    Quat turn;
    Vec3 faster = Vec3::Zero();  // [m/s], in body axes of the beginning
    Vec3 moved = Vec3::Zero();   // [m]
    auto state() const { return std::tie(turn, faster, moved); }
    bool operator==(const Stride& o) const { return state() == o.state(); }
  };
  /// The stride that is not complete yet.
  struct Begun {
    std::uint64_t since_us = 0;
    Quat q_WB;
    Vec3 faster_W = Vec3::Zero(), moved_W = Vec3::Zero();
    auto state() const { return std::tie(since_us, q_WB, faster_W, moved_W); }
    bool operator==(const Begun& o) const { return state() == o.state(); }
  };

  Motion now_;
  std::uint64_t t_us_ = 0;
  std::uint32_t remembered_ = 0;  // complete strides, at most kStrides - 2
  std::array<Stride, kStrides> steps_ = {};
  Begun begun_;
};

}  // namespace halfroll
