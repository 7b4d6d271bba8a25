#include "sim/wind.hpp"

#include <algorithm>

#include "core/trig.hpp"
#include "sim/lag.hpp"

namespace halfroll::sim {
namespace {

constexpr double kDtS = 1e-3;

/// Share of a gust that blows at time t [s].
double share_of(const Gust& gust, double t) {
  const double since = t - gust.at_s, left = 2.0 * gust.rise_s + gust.hold_s - since;
  const double edge = std::min(since, left);
  if (edge <= 0.0) return 0.0;
  if (edge >= gust.rise_s) return 1.0;
  return 0.5 - 0.5 * static_cast<double>(cosine(static_cast<float>(edge / gust.rise_s) * kPi));
}

// H(s) = sigma sqrt(tau) (1 + sqrt(3) tau s) / (1 + tau s)^2 is sqrt(3) times a lag of white noise and 1 - sqrt(3)
// times a lag of that lag; with the first of unit variance the sum has variance 2.
double transverse(const std::array<double, 2>& z) {
  const double root_3 = std::sqrt(3.0);
  return (root_3 * z[0] + (1.0 - root_3) * z[1]) / std::sqrt(2.0);
}

}  // namespace

WindModel::WindModel(const WindSetup& setup)
    : setup_(setup),
      turbulent_((setup.intensity.array() > 0.0).any()),
      gusty_(std::any_of(setup.gusts.begin(), setup.gusts.end(),
                         [](const Gust& gust) { return (gust.velocity.array() != 0.0).any(); })),
      along_W_(Vec3d::UnitX()),
      across_W_(Vec3d::UnitY()) {
  blows_ = turbulent_ || gusty_ || (setup.mean.array() != 0.0).any();
  const Vec3d level(setup.mean.x(), setup.mean.y(), 0.0);
  if (level.norm() > 1e-9) along_W_ = level.normalized(), across_W_ = Vec3d::UnitZ().cross(along_W_);
  const double speed = setup.speed > 0.0 ? setup.speed : setup.mean.norm();
  along_ = filter(setup.length.x(), speed);
  across_ = filter(setup.length.y(), speed);
  vertical_ = filter(setup.length.z(), speed);
}

WindModel::Filter WindModel::filter(double length, double speed) {
  const double x = kDtS * speed / length, a = 1.0 - covered(x);
  Filter f;
  f.keep = a;
  f.carry = a * x;
  // covariance gained in a step: P - F P F' with P = [1, 1/2; 1/2, 1/2], F = [a, 0; a x, a]
  const double q11 = 1.0 - a * a, q12 = 0.5 - a * a * (x + 0.5), q22 = 0.5 - a * a * (x * x + x + 0.5);
  f.drive = std::sqrt(q11);
  f.to_second = q11 > 0.0 ? q12 / f.drive : 0.0;
  f.second = std::sqrt(std::max(0.0, q22 - f.to_second * f.to_second));
  return f;
}

Wind WindModel::start(const Random& random) const {
  Wind wind;
  if (turbulent_) {
    const auto n = random.normals<3>(Stream::kTurbulence, 0);
    const auto m = random.normals<2>(Stream::kTurbulenceCross, 0);
    wind.along = n[0];
    wind.across = {n[1], 0.5 * (n[1] + m[0])};
    wind.vertical = {n[2], 0.5 * (n[2] + m[1])};
  }
  if (blows_) sum_up(wind, 0);
  return wind;
}

void WindModel::advance(Wind& wind, const Random& random, std::uint64_t t_us) const {
  if (turbulent_) {
    const auto n = random.normals<3>(Stream::kTurbulence, t_us / 1000);
    const auto m = random.normals<2>(Stream::kTurbulenceCross, t_us / 1000);
    wind.along = along_.keep * wind.along + along_.drive * n[0];
    const auto move = [](std::array<double, 2>& z, const Filter& f, double e1, double e2) {
      z[1] = f.keep * z[1] + f.carry * z[0] + f.to_second * e1 + f.second * e2;
      z[0] = f.keep * z[0] + f.drive * e1;
    };
    move(wind.across, across_, n[1], m[0]);
    move(wind.vertical, vertical_, n[2], m[1]);
  }
  if (turbulent_ || gusty_) sum_up(wind, t_us);
}

void WindModel::sum_up(Wind& wind, std::uint64_t t_us) const {
  wind.velocity_W = setup_.mean;
  if (turbulent_) {
    wind.velocity_W += setup_.intensity.x() * wind.along * along_W_ +
                       setup_.intensity.y() * transverse(wind.across) * across_W_ +
                       setup_.intensity.z() * transverse(wind.vertical) * Vec3d::UnitZ();
  }
  if (!gusty_) return;
  for (const Gust& gust : setup_.gusts)
    wind.velocity_W += share_of(gust, 1e-6 * static_cast<double>(t_us)) * gust.velocity;
}

}  // namespace halfroll::sim
