// Sensors of a laboratory, and of a field, in double: what the estimator is tested with. Why: noise, biases and delays
// are the test's own, so the filter is measured against numbers that it was not made from.
#pragma once
#include <Eigen/Eigenvalues>
#include <deque>
#include <optional>

#include "oracle.hpp"

namespace oracle {

/// The truth that sensors see.
struct Seen {
  Vec3d p = Vec3d::Zero(), v = Vec3d::Zero(), w_B = Vec3d::Zero(), specific_force_B = Vec3d::Zero();
  Quatd q = Quatd::Identity();
};

class SensorSuite {
 public:
  int pose_every_ms = 10, pose_delay_ms = 20;
  double gyro = 0.01, accelerometer = 0.1, position = 1e-3, attitude = 0.03 * kDegree;  // standard deviations
  double wander = 0.2 * kDegree, wander_time = 0.5;
  double gyro_bias = 0.02, accelerometer_bias = 0.2, gyro_walk = 3e-4, accelerometer_walk = 0.003;
  double outliers = 0.0, outlier_size = 0.5;  // share of poses; [m] and [rad]
  bool poses = true, outdoors = false;

  /// Biases are drawn with the first sample.
  explicit SensorSuite(unsigned seed) : random_(seed) {}

  Vec3d true_gyro_bias() const { return b_gyro_; }
  Vec3d true_accelerometer_bias() const { return b_accelerometer_; }
  /// Whether the latest pose delivered was a lie.
  bool lied() const { return lied_; }

  /// What comes in millisecond k.
  halfroll::Measurements read(int k, const Seen& truth) {
    if (k == 0) {
      b_gyro_ = random_.normal3(gyro_bias);
      b_accelerometer_ = random_.normal3(accelerometer_bias);
      wander_ = random_.normal3(wander);
    }
    b_gyro_ += random_.normal3(gyro_walk * std::sqrt(1e-3));
    b_accelerometer_ += random_.normal3(accelerometer_walk * std::sqrt(1e-3));
    halfroll::Measurements m;
    m.imu.w_WB_B = (truth.w_B + b_gyro_ + random_.normal3(gyro)).cast<float>();
    m.imu.specific_force_B = (truth.specific_force_B + b_accelerometer_ + random_.normal3(accelerometer)).cast<float>();
    if (k % pose_every_ms == 0) expose(k, truth);
    if (!on_the_way_.empty() &&
        on_the_way_.front().pose.t_us + 1000U * static_cast<unsigned>(pose_delay_ms) <= now(k)) {
      if (poses) m.pose = on_the_way_.front().pose;
      lied_ = on_the_way_.front().lie;
      on_the_way_.pop_front();
    }
    if (outdoors) look_around(k, truth, m);
    return m;
  }

 private:
  struct Exposed {
    halfroll::PoseFix pose;
    bool lie = false;
  };
  static std::uint64_t now(int k) { return static_cast<std::uint64_t>(k) * 1000; }

  void expose(int k, const Seen& truth) {
    const double kept = std::exp(-1e-3 * pose_every_ms / wander_time);
    wander_ = kept * wander_ + random_.normal3(wander * std::sqrt(1.0 - kept * kept));
    Exposed e;
    e.lie = random_.uniform(0.0, 1.0) < outliers;
    e.pose.t_us = now(k);
    e.pose.p_WB = (truth.p + random_.normal3(e.lie ? outlier_size : position)).cast<float>();
    e.pose.q_WB = to_core(truth.q * turn(random_.normal3(e.lie ? outlier_size : attitude) + wander_));
    on_the_way_.push_back(e);
  }

  void look_around(int k, const Seen& truth, halfroll::Measurements& m) {
    if (k % 100 == 0) {  // satellites at 10 Hz, 120 ms late
      halfroll::GpsFix fix;
      fix.t_us = now(k);
      fix.p_WB = (truth.p + random_.normal3(0.5)).cast<float>();
      fix.v_WB = (truth.v + random_.normal3(0.05)).cast<float>();
      fix.horizontal_deviation = fix.vertical_deviation = 0.5F;
      fix.speed_deviation = 0.05F;
      fixes_.push_back(fix);
    }
    if (!fixes_.empty() && fixes_.front().t_us + 120000 <= now(k)) {
      m.gps = fixes_.front();
      fixes_.pop_front();
    }
    if (k % 40 == 0) {
      m.barometer = halfroll::BarometerSample{now(k), static_cast<float>(truth.p.z() + 37.0 + 0.2 * random_.normal())};
    }
    if (k % 20 == 0) {  // 63 deg steep
      const Vec3d field = truth.q.conjugate() * Vec3d(0.454, 0.0, -0.891) + random_.normal3(0.01);
      m.magnetometer = halfroll::MagnetometerSample{now(k), field.cast<float>()};
    }
  }

  Random random_;
  Vec3d b_gyro_ = Vec3d::Zero(), b_accelerometer_ = Vec3d::Zero(), wander_ = Vec3d::Zero();
  std::deque<Exposed> on_the_way_;
  std::deque<halfroll::GpsFix> fixes_;
  bool lied_ = false;
};

}  // namespace oracle
