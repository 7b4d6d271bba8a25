#include "core/error_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll {
namespace {

using namespace error_state;

// Variances are kept in this range: below, float32 no longer tells them from 0; above, nothing is known anyway.
constexpr std::array<float, 5> kLeast = {1e-10F, 1e-9F, 1e-10F, 1e-12F, 1e-9F};
constexpr std::array<float, 5> kMost = {10.F, 1e4F, 1e6F, 1.F, 10.F};

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.F, -v.z(), v.y(), v.z(), 0.F, -v.x(), -v.y(), v.x(), 0.F;
  return m;
}

}  // namespace

/// The three errors from `to` have become larger by m times those from `from`, which stay: P Phi^T by columns, and the
/// same by rows, which symmetry gives but where those three meet themselves. What is 0 in m costs nothing.
void ErrorCovariance::add(int to, int from, const Mat3& m) {
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 3; ++k) {
      if (m(j, k) == 0.F) continue;
      for (int i = 0; i < kSize; ++i) p_(i, to + j) += m(j, k) * p_(i, from + k);
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      if (m(i, k) == 0.F) continue;
      for (int j = i; j < 3; ++j) p_(to + i, to + j) += m(i, k) * p_(from + k, to + j);
    }
    for (int j = i; j < 3; ++j) p_(to + j, to + i) = p_(to + i, to + j);
  }
  for (int j = to; j < to + 3; ++j) {
    for (int i = 0; i < kSize; ++i) p_(j, i) = p_(i, j);
  }
}

// Over dt:  attitude += -R dt gyro_bias;  velocity += -[faster]x attitude - R dt accelerometer_bias;
//           position += dt times the mean of the velocity error before and after.
void ErrorCovariance::propagate(float dt, const Mat3& R_WB, const Vec3& faster_W, const InertialNoise& noise) {
  const Mat3 turned = -dt * R_WB, half = 0.5F * dt * Mat3::Identity();
  add(kPosition, kVelocity, half);
  add(kVelocity, kAttitude, -cross_matrix(faster_W));
  add(kVelocity, kAccelerometerBias, turned);
  add(kPosition, kVelocity, half);
  add(kAttitude, kGyroBias, turned);
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

// Number by number, as their noise is independent: nothing is inverted, and no row of the observation has more than
// five entries. P loses g g^T, g = P h / sqrt(h^T P h + R), which is symmetric to the last bit; distances add up.
template <int N>
float ErrorCovariance::fuse(const Observation<N>& seen, ErrorVector& found) {
  float distance2 = 0.F;
  for (int n = 0; n < N; ++n) {
    ErrorVector g = ErrorVector::Zero();  // P h
    float spread = seen.variance(n), unexplained = seen.innovation(n);
    const auto each = [&](const auto& use) {
      if (seen.position != 0.F) use(kPosition + seen.axis + n, seen.position);
      if (seen.velocity != 0.F) use(kVelocity + seen.axis + n, seen.velocity);
      for (int k = 0; k < 3; ++k) {
        if (seen.attitude(n, k) != 0.F) use(kAttitude + k, seen.attitude(n, k));
      }
    };
    each([&](int entry, float h) {
      for (int i = 0; i < kSize; ++i) g(i) += h * p_(i, entry);
      unexplained -= h * found(entry);
    });
    each([&](int entry, float h) { spread += h * g(entry); });
    const float scale = 1.F / std::sqrt(spread);
    const float off = scale * unexplained;
    g *= scale;
    distance2 += off * off;
    found += off * g;
    for (int j = 0; j < kSize; ++j) {
      for (int i = 0; i < kSize; ++i) p_(i, j) -= g(j) * g(i);
    }
  }
  for (int j = 0; j < kSize; ++j) p_(j, j) = std::max(p_(j, j), kLeast[static_cast<std::size_t>(j) / 3]);
  return distance2;
}

template float ErrorCovariance::fuse(const Observation<1>&, ErrorVector&);
template float ErrorCovariance::fuse(const Observation<3>&, ErrorVector&);

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

/// Every variance in range; one that is too large takes its covariances down with it.
void ErrorCovariance::keep_safe() {
  for (int j = 0; j < kSize; ++j) {
    const float most = kMost[static_cast<std::size_t>(j) / 3];
    p_(j, j) = std::max(p_(j, j), kLeast[static_cast<std::size_t>(j) / 3]);
    if (p_(j, j) <= most) continue;
    const float scale = std::sqrt(most / p_(j, j));
    p_.col(j) *= scale;
    p_.row(j) *= scale;
  }
}

}  // namespace halfroll
