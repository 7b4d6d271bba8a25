// The inverse of the motor lag against a motor. Why: fixed-pitch gains assume motors LAG_COMP times faster.
#include "core/rotor.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "oracle.hpp"

namespace halfroll {
namespace {

/// Time for a motor to make 90 % of a small thrust step [s].
double rise(float lag_compensation) {
  const Vehicle vehicle = oracle::fixed_pitch_vehicle();
  Params params;
  params.lag_compensation = lag_compensation;
  RotorLagInverse inverse;
  double speed = std::sqrt(0.15);
  const double share = 1.0 - std::exp(-1e-3 / 0.12);
  for (int i = 0; i < 4000; ++i) {
    const float wanted = i < 2000 ? 1.4F : 1.5F;
    const float command = inverse.step({{wanted, wanted, wanted, wanted}}, vehicle, params).thrust[0];
    speed += share * (std::sqrt(static_cast<double>(command)) - speed);
    if (i >= 2000 && speed * speed > 1.49) return (i - 2000) * 1e-3;
  }
  return 99.0;
}

}  // namespace

TEST_CASE("motors follow LAG_COMP times faster than they do by themselves") {
  CHECK(rise(1.F) == doctest::Approx(0.12 * std::log(10.0)).epsilon(0.03));
  CHECK(rise(3.F) == doctest::Approx(0.04 * std::log(10.0)).epsilon(0.03));
}

TEST_CASE("variable-pitch commands pass through untouched") {
  const RotorCommands wanted{{-3.F, 0.F, 0.7F, 3.F}};
  RotorLagInverse inverse;
  CHECK(inverse.step(wanted, oracle::paper_vehicle(), Params{}) == wanted);
}

TEST_CASE("fixed-pitch commands stay inside the limits whatever is wanted") {
  oracle::Random random(1);
  const Vehicle vehicle = oracle::fixed_pitch_vehicle();
  RotorLagInverse inverse;
  for (int i = 0; i < 5000; ++i) {
    RotorCommands wanted;
    for (float& f : wanted.thrust) f = static_cast<float>(random.uniform(-1.0, 4.0));
    for (const float f : inverse.step(wanted, vehicle, Params{}).thrust) {
      REQUIRE(f >= vehicle.thrust_min);
      REQUIRE(f <= vehicle.thrust_max);
    }
  }
}

}  // namespace halfroll
