// How wrong the estimate may be: the covariance of its fifteen errors.
// Why: it weighs every measurement, so it must stay symmetric and positive in float32 for as long as a vehicle is on.
//
// Errors are truth minus estimate, all in W but the biases, which are in B: attitude (a rotation vector, R = exp(error)
// R_believed), velocity, position, gyro bias, accelerometer bias. With the attitude error in W nothing depends on being
// upright, and what the error does over an interval needs only the specific force gained in it.
#pragma once
#include "core/types.hpp"

namespace halfroll {

namespace error_state {
inline constexpr int kAttitude = 0, kVelocity = 3, kPosition = 6, kGyroBias = 9, kAccelerometerBias = 12, kSize = 15;
}

using ErrorVector = Eigen::Matrix<float, error_state::kSize, 1>;

/// N numbers measured: innovation = attitude * (attitude error) + velocity * (velocity error along `axis`...) +
/// position * (position error along `axis`...) + noise.
template <int N>
struct Observation {
  Eigen::Matrix<float, N, 1> innovation = Eigen::Matrix<float, N, 1>::Zero();
  Eigen::Matrix<float, N, 1> variance = Eigen::Matrix<float, N, 1>::Zero();
  Eigen::Matrix<float, N, 3> attitude = Eigen::Matrix<float, N, 3>::Zero();
  float velocity = 0.F, position = 0.F;
  int axis = 0;  // of the first number; the others follow
};

/// White noise of the inertial sensors as variance per second, and how fast their biases walk.
struct InertialNoise {
  float gyro = 0.F;                // [rad²/s]
  float accelerometer = 0.F;       // [m²/s³]
  float gyro_walk = 0.F;           // [rad²/s³]
  float accelerometer_walk = 0.F;  // [m²/s⁵]
};

/// What up to six numbers seen at one instant tell of the errors. Nothing is believed before it is taken.
class Findings {
 public:
  ErrorVector errors() const { return errors_.head<error_state::kSize>(); }

 private:
  friend class ErrorCovariance;
  static constexpr int kMost = 6, kRows = 16;

  /// Of each number P h by the standard deviation of its innovation, 0 where there is none; filled up to fours of rows.
  Eigen::Matrix<float, kRows, kMost> gains_ = Eigen::Matrix<float, kRows, kMost>::Zero();
  Eigen::Matrix<float, kRows, 1> errors_ = Eigen::Matrix<float, kRows, 1>::Zero();
  int count_ = 0;
};

class ErrorCovariance {
 public:
  using Matrix = Eigen::Matrix<float, error_state::kSize, error_state::kSize>;

  /// dt seconds on: R_WB in the middle, what the specific force added to the velocity, noise.
  void propagate(float dt, const Mat3& R_WB, const Vec3& faster_W, const InertialNoise& noise);

  /// Look at an observation after those `found` before in this instant: its innovation is what they do not explain.
  /// Returns the Mahalanobis distance of that, squared, as seen from before: chi² of N when all is well.
  template <int N>
  float look(const Observation<N>& seen, Findings& found) const;
  /// Be as sure as what was found makes one.
  void take(const Findings& found);

  /// Forget what is known of three errors: independent of the rest, with these variances.
  void set(int first, const Vec3& variance);
  /// The same of velocity and position when a velocity of this variance has moved it for `age` seconds.
  void set_moving(const Vec3& position_variance, float velocity_variance, float age);

  /// Largest standard deviation of the three errors from `first`.
  float deviation(int first) const;
  float variance(int error) const { return p_(error, error); }
  Matrix matrix() const { return p_.topRows<error_state::kSize>(); }
  auto state() const { return std::tie(p_); }
  bool operator==(const ErrorCovariance& o) const { return p_ == o.p_; }

 private:
  void keep_safe();

  /// Symmetric. Columns are filled up to fours of rows, what a processor takes at once; nothing is in the last row.
  using Columns = Eigen::Matrix<float, Findings::kRows, error_state::kSize>;
  Columns p_ = Columns::Identity();
};

}  // namespace halfroll
