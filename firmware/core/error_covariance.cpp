#include "core/error_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace halfroll {
namespace {

using namespace error_state;

// Variances are kept in this range: below, float32 no longer tells them from 0; above, nothing is known anyway.
constexpr std::array<float, 5> kLeast = {1e-10F, 1e-9F, 1e-10F, 1e-12F, 1e-9F};
constexpr std::array<float, 5> kMost = {10.F, 1e4F, 1e6F, 1.F, 10.F};

/// What the errors of now become over dt.
struct Transition {
  float half;     // dt / 2
  Mat3 turned;    // -dt R
  Vec3 faster_W;  // by the specific force

  /// Of fifteen errors that stand `Apart` in memory.
  template <int Apart>
  void apply(float* errors) const {
    const auto e = [errors](int n) -> float& { return errors[n * Apart]; };
    const auto by_bias = [&](int j, int bias) {
      return turned(j, 0) * e(bias) + turned(j, 1) * e(bias + 1) + turned(j, 2) * e(bias + 2);
    };
    for (int j = 0; j < 3; ++j) e(kPosition + j) += half * e(kVelocity + j);
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      e(kVelocity + j) += e(kAttitude + k) * faster_W(l) - e(kAttitude + l) * faster_W(k);
      e(kVelocity + j) += by_bias(j, kAccelerometerBias);
    }
    for (int j = 0; j < 3; ++j) e(kPosition + j) += half * e(kVelocity + j);
    for (int j = 0; j < 3; ++j) e(kAttitude + j) += by_bias(j, kGyroBias);
  }
};

}  // namespace

// Over dt:  attitude += -R dt gyro_bias;  velocity += attitude x faster - R dt accelerometer_bias;
//           position += dt times the mean of the velocity error before and after.
// Phi P Phi^T: every row of P, then every column of that but the biases', which stay and are the rows already there.
void ErrorCovariance::propagate(float dt, const Mat3& R_WB, const Vec3& faster_W, const InertialNoise& noise) {
  const Transition over{0.5F * dt, -dt * R_WB, faster_W};
  for (int i = 0; i < Columns::RowsAtCompileTime; ++i) over.apply<Columns::RowsAtCompileTime>(&p_(i, 0));
  for (int j = 0; j < kGyroBias; ++j) over.apply<1>(&p_(0, j));
  for (int j = 0; j < kGyroBias; ++j) {
    for (int i = 0; i < j; ++i) p_(j, i) = p_(i, j);
    for (int i = kGyroBias; i < kSize; ++i) p_(j, i) = p_(i, j);
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

// Number by number, as their noise is independent: nothing is inverted, and no row of the observation has more than
// five entries. A number makes P lose g g^T, g = P h / sqrt(h^T P h + R), which those after it must allow for.
template <int N>
float ErrorCovariance::look(const Observation<N>& seen, Findings& found) const {
  float distance2 = 0.F;
  for (int n = 0; n < N; ++n) {
    const auto each = [&](const auto& use) {
      if (seen.position != 0.F) use(kPosition + seen.axis + n, seen.position);
      if (seen.velocity != 0.F) use(kVelocity + seen.axis + n, seen.velocity);
      for (int k = 0; k < 3; ++k) {
        if (seen.attitude(n, k) != 0.F) use(kAttitude + k, seen.attitude(n, k));
      }
    };
    Eigen::Matrix<float, Findings::kRows, 1> g = Eigen::Matrix<float, Findings::kRows, 1>::Zero();  // P h
    float spread = seen.variance(n), unexplained = seen.innovation(n);
    each([&](int entry, float h) {
      g += h * p_.col(entry);
      unexplained -= h * found.errors_(entry);
    });
    for (int before = 0; before < found.count_; ++before) {
      float known = 0.F;
      each([&](int entry, float h) { known += h * found.gains_(entry, before); });
      g -= known * found.gains_.col(before);
    }
    each([&](int entry, float h) { spread += h * g(entry); });
    const float scale = 1.F / std::sqrt(spread);
    const float off = scale * unexplained;
    g *= scale;
    distance2 += off * off;
    found.errors_ += off * g;
    found.gains_.col(found.count_++) = g;
  }
  return distance2;
}

template float ErrorCovariance::look(const Observation<1>&, Findings&) const;
template float ErrorCovariance::look(const Observation<3>&, Findings&) const;

void ErrorCovariance::take(const Findings& found) {
  const auto gains = found.gains_;
  for (int j = 0; j < kSize; ++j) {
    float* const p = &p_(0, j);
    const int rows = (j | 3) + 1;  // down to the diagonal, in fours
    for (int i = 0; i < rows; ++i) {
      p[i] = p[i] - gains(j, 0) * gains(i, 0) - gains(j, 1) * gains(i, 1) - gains(j, 2) * gains(i, 2) -
             gains(j, 3) * gains(i, 3) - gains(j, 4) * gains(i, 4) - gains(j, 5) * gains(i, 5);
    }
    p_(j, j) = std::max(p_(j, j), kLeast[static_cast<std::size_t>(j) / 3]);
    for (int i = 0; i < j; ++i) p_(j, i) = p_(i, j);
  }
}

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
