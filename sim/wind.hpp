// Moving air: a mean, gusts, and Dryden turbulence. Why: a position loop shows its worth only where something pushes,
// and the same seed must push the same way.
//
// Turbulence is the Dryden model of MIL-F-8785C as forming filters, driven by white noise and sampled exactly once a
// millisecond; the frozen field is carried past the vehicle with the mean wind. "Along" is the mean's direction.
#pragma once
#include "sim/random.hpp"
#include "sim/scenario.hpp"

namespace halfroll::sim {

struct Wind {
  Vec3d velocity_W = Vec3d::Zero();  // [m/s], of the air
  double along = 0.0;                // filter states, unit variance
  std::array<double, 2> across = {0.0, 0.0}, vertical = {0.0, 0.0};
};

class WindModel {
 public:
  explicit WindModel(const WindSetup& setup);

  bool blows() const { return blows_; }
  /// Air at time 0, drawn from the stationary distribution.
  Wind start(const Random& random) const;
  /// Air a millisecond later, at t_us.
  void advance(Wind& wind, const Random& random, std::uint64_t t_us) const;

 private:
  /// One or two equal poles in series; the second filter's covariance by its Cholesky factor.
  struct Filter {
    double keep = 0.0, carry = 0.0;  // a = exp(-dt/tau), a dt/tau
    double drive = 0.0, to_second = 0.0, second = 0.0;
  };
  static Filter filter(double length, double speed);
  void sum_up(Wind& wind, std::uint64_t t_us) const;

  WindSetup setup_;
  bool blows_, turbulent_, gusty_;
  Vec3d along_W_, across_W_;
  Filter along_, across_, vertical_;
};

}  // namespace halfroll::sim
