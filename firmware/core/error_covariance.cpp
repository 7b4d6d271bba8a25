#include "core/error_covariance.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace halfroll {
namespace {

using namespace error_state;

// Variances are kept in this range: below, float32 no longer tells them from 0; above, nothing is known anyway.
constexpr std::array<float, 5> kLeast = {1e-10F, 1e-9F, 1e-10F, 1e-12F, 1e-9F};
constexpr std::array<float, 5> kMost = {10.F, 1e4F, 1e6F, 1.F, 10.F};

using Matrix = ErrorCovariance::Matrix;

/// Columns from `from` times m^T added to those from `to`: one block of a multiplication by Phi^T.
void add(Matrix& p, int to, int from, const Mat3& m) {
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 3; ++k) p.col(to + j) += m(j, k) * p.col(from + k);
  }
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.F, -v.z(), v.y(), v.z(), 0.F, -v.x(), -v.y(), v.x(), 0.F;
  return m;
}

}  // namespace

// Over dt:  attitude += -R dt gyro_bias;  velocity += -[faster]x attitude - R dt accelerometer_bias;
//           position += dt times the mean of the velocity error before and after.
void ErrorCovariance::propagate(float dt, const Mat3& R_WB, const Vec3& faster_W, const InertialNoise& noise) {
  const Mat3 turned = -dt * R_WB, pushed = -cross_matrix(faster_W);
  for (int side = 0; side < 2; ++side) {  // P Phi^T, and the transpose of that again
    for (int j = 0; j < 3; ++j) p_.col(kPosition + j) += 0.5F * dt * p_.col(kVelocity + j);
    add(p_, kVelocity, kAttitude, pushed);
    add(p_, kVelocity, kAccelerometerBias, turned);
    for (int j = 0; j < 3; ++j) p_.col(kPosition + j) += 0.5F * dt * p_.col(kVelocity + j);
    add(p_, kAttitude, kGyroBias, turned);
    p_.transposeInPlace();
  }
  const float q = noise.accelerometer * dt;
  for (int j = 0; j < 3; ++j) {
    p_(kAttitude + j, kAttitude + j) += noise.gyro * dt;
    p_(kVelocity + j, kVelocity + j) += q;
    p_(kPosition + j, kPosition + j) += q * dt * dt / 3.F;
    p_(kVelocity + j, kPosition + j) += 0.5F * q * dt;
    p_(kPosition + j, kVelocity + j) += 0.5F * q * dt;
    p_(kGyroBias + j, kGyroBias + j) += noise.gyro_walk * dt;
    p_(kAccelerometerBias + j, kAccelerometerBias + j) += noise.accelerometer_walk * dt;
  }
  keep_safe();
}

/// P H^T.
template <int N>
Eigen::Matrix<float, kSize, N> ErrorCovariance::against(const Observation<N>& seen) const {
  Eigen::Matrix<float, kSize, N> m;
  for (int i = 0; i < N; ++i) {
    m.col(i) = seen.velocity * p_.col(kVelocity + seen.axis + i) + seen.position * p_.col(kPosition + seen.axis + i);
    for (int k = 0; k < 3; ++k) m.col(i) += seen.attitude(i, k) * p_.col(kAttitude + k);
  }
  return m;
}

namespace {

/// H P H^T + R, of P H^T.
template <int N>
Eigen::Matrix<float, N, N> spread(const Observation<N>& seen, const Eigen::Matrix<float, kSize, N>& m) {
  Eigen::Matrix<float, N, N> s;
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      s(i, j) = seen.velocity * m(kVelocity + seen.axis + i, j) + seen.position * m(kPosition + seen.axis + i, j);
      for (int k = 0; k < 3; ++k) s(i, j) += seen.attitude(i, k) * m(kAttitude + k, j);
    }
    s(i, i) += seen.variance(i);
  }
  return s;
}

}  // namespace

template <int N>
Weighed<N> ErrorCovariance::weigh(const Observation<N>& seen) const {
  Weighed<N> w;
  w.against = against(seen);
  w.inverse = spread(seen, w.against).inverse();
  w.distance2 = seen.innovation.dot(w.inverse.lazyProduct(seen.innovation).eval());
  return w;
}

// Joseph's form written out: P - K M^T - (M - K S) K^T, which errs only to second order where K is rounded.
template <int N>
void ErrorCovariance::fuse(const Observation<N>& seen, const Weighed<N>& weighed, ErrorVector& found) {
  const auto& m = weighed.against;
  const Eigen::Matrix<float, kSize, N> gain = m.lazyProduct(weighed.inverse);
  const Eigen::Matrix<float, kSize, N> rest = m - gain.lazyProduct(spread(seen, m));
  Eigen::Matrix<float, N, 1> unexplained = seen.innovation;
  for (int i = 0; i < N; ++i) {
    unexplained(i) -=
        seen.velocity * found(kVelocity + seen.axis + i) + seen.position * found(kPosition + seen.axis + i);
    for (int k = 0; k < 3; ++k) unexplained(i) -= seen.attitude(i, k) * found(kAttitude + k);
  }
  for (int n = 0; n < N; ++n) found += unexplained(n) * gain.col(n);
  for (int j = 0; j < kSize; ++j) {
    ErrorVector less = m(j, 0) * gain.col(0) + gain(j, 0) * rest.col(0);
    for (int n = 1; n < N; ++n) less += m(j, n) * gain.col(n) + gain(j, n) * rest.col(n);
    p_.col(j) -= less;
    p_(j, j) = std::max(p_(j, j), kLeast[static_cast<std::size_t>(j) / 3]);
    for (int i = 0; i < j; ++i) p_(i, j) = p_(j, i);
  }
}

template Weighed<1> ErrorCovariance::weigh(const Observation<1>&) const;
template Weighed<3> ErrorCovariance::weigh(const Observation<3>&) const;
template void ErrorCovariance::fuse(const Observation<1>&, const Weighed<1>&, ErrorVector&);
template void ErrorCovariance::fuse(const Observation<3>&, const Weighed<3>&, ErrorVector&);

void ErrorCovariance::set(int first, const Vec3& variance) {
  p_.middleRows<3>(first).setZero();
  p_.middleCols<3>(first).setZero();
  for (int j = 0; j < 3; ++j) p_(first + j, first + j) = variance(j);
}

void ErrorCovariance::set_moving(const Vec3& position_variance, float velocity_variance, float age) {
  set(kVelocity, Vec3::Constant(velocity_variance));
  set(kPosition, position_variance + Vec3::Constant(age * age * velocity_variance));
  for (int j = 0; j < 3; ++j) {
    p_(kVelocity + j, kPosition + j) = p_(kPosition + j, kVelocity + j) = age * velocity_variance;
  }
}

float ErrorCovariance::deviation(int first) const {
  return std::sqrt(std::max({p_(first, first), p_(first + 1, first + 1), p_(first + 2, first + 2)}));
}

/// Symmetric again, and every variance in range; one that is too large takes its covariances down with it.
void ErrorCovariance::keep_safe() {
  for (int j = 0; j < kSize; ++j) {
    for (int i = 0; i < j; ++i) p_(j, i) = p_(i, j) = 0.5F * (p_(i, j) + p_(j, i));
    const float most = kMost[static_cast<std::size_t>(j) / 3];
    p_(j, j) = std::max(p_(j, j), kLeast[static_cast<std::size_t>(j) / 3]);
    if (p_(j, j) <= most) continue;
    const float scale = std::sqrt(most / p_(j, j));
    p_.col(j) *= scale;
    p_.row(j) *= scale;
  }
}

}  // namespace halfroll
