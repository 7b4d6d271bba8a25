// The paper's Fig 2: a flip through free fall. Why: its force passes through zero, where every formula of the outer
// loop is at its worst. Two 9th-order segments, continuous to the 8th derivative, acceleration fixed in the middle.
#pragma once
#include "oracle.hpp"

namespace oracle {

class FreeFallFlip {
 public:
  static constexpr double kDuration = 1.0634, kHalf = kDuration / 2.0, kWidth = 0.4;

  FreeFallFlip() : x_(solve(0.0, kWidth)), z_(solve(-kGravity, 0.0)) {}

  /// The order-th derivative of position at t; at rest before and after.
  Vec3d at(double t, int order) const { return {along(x_, t, order), 0.0, along(z_, t, order)}; }

  /// m (r'' + g) without the mass.
  Vec3d force(double t) const { return at(t, 2) + Vec3d(0.0, 0.0, kGravity); }

  /// Rate of the thrust axis in the x-z plane, about body y.
  double rate(double t) const {
    const Vec3d f = force(t), f1 = at(t, 3);
    return (f.z() * f1.x() - f.x() * f1.z()) / f.squaredNorm();
  }

 private:
  using Coefficients = Eigen::Matrix<double, 20, 1>;

  static double term(int power, int order, double tau) {
    double factor = 1.0;
    for (int i = 0; i < order; ++i) factor *= power - i;
    return power < order ? 0.0 : factor * std::pow(tau, power - order);
  }

  static Coefficients solve(double middle_acceleration, double end) {
    Eigen::Matrix<double, 20, 20> rows = Eigen::Matrix<double, 20, 20>::Zero();
    Coefficients wanted = Coefficients::Zero();
    int row = 0;
    const auto fix = [&](int segment, int order, double tau, double target) {
      for (int i = 0; i < 10; ++i) rows(row, 10 * segment + i) = term(i, order, tau);
      wanted(row++) = target;
    };
    for (int order = 0; order < 5; ++order) {
      fix(0, order, 0.0, 0.0);
      fix(1, order, 1.0, order == 0 ? end : 0.0);
    }
    fix(0, 2, 1.0, middle_acceleration * kHalf * kHalf);
    fix(1, 2, 0.0, middle_acceleration * kHalf * kHalf);
    for (int order = 0; order < 9; ++order) {
      if (order == 2) continue;
      for (int i = 0; i < 10; ++i) {
        rows(row, i) = term(i, order, 1.0);
        rows(row, 10 + i) = -term(i, order, 0.0);
      }
      ++row;
    }
    for (int i = 0; i < 20; ++i) {
      const double scale = rows.row(i).cwiseAbs().maxCoeff();
      rows.row(i) /= scale;
      wanted(i) /= scale;
    }
    return rows.fullPivLu().solve(wanted);
  }

  static double along(const Coefficients& c, double t, int order) {
    if (order > 0 && (t < 0.0 || t > kDuration)) return 0.0;
    t = std::min(std::max(t, 0.0), kDuration);
    const int segment = t < kHalf ? 0 : 1;
    const double tau = t / kHalf - segment;
    double sum = 0.0;
    for (int i = 0; i < 10; ++i) sum += c(10 * segment + i) * term(i, order, tau);
    return sum / std::pow(kHalf, order);
  }

  Coefficients x_, z_;
};

/// The flip as the outer loop wants it.
inline halfroll::FlatReference reference(const FreeFallFlip& flip, double t) {
  halfroll::FlatReference r;
  r.position = flip.at(t, 0).cast<float>();
  r.velocity = flip.at(t, 1).cast<float>();
  r.acceleration = flip.at(t, 2).cast<float>();
  r.jerk = flip.at(t, 3).cast<float>();
  r.snap = flip.at(t, 4).cast<float>();
  return r;
}

}  // namespace oracle
