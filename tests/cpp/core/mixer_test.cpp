// The mixer against scans of all rotor thrusts. Why: at saturation somebody must yield, in the stated order, always.
#include "core/mixer.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "oracle.hpp"

namespace halfroll {
namespace {

using oracle::Random;

Wrench random_wrench(Random& random, double excess) {
  Wrench w;
  w.thrust = static_cast<float>(random.uniform(-14.0, 14.0) * excess);
  w.torque = {static_cast<float>(random.uniform(-1.2, 1.2) * excess),
              static_cast<float>(random.uniform(-1.2, 1.2) * excess),
              static_cast<float>(random.uniform(-0.14, 0.14) * excess)};
  return w;
}

/// Nearest to `wanted` of `quantity(f3, f4)` over rotors 3 and 4, with the differences u and v given.
template <class Quantity>
double nearest(double wanted, double u, double v, double least, double most, const Quantity& quantity) {
  const int kSteps = 200;
  const double f3_least = std::max(least, least - u), f3_most = std::min(most, most - u);
  const double f4_least = std::max(least, least - v), f4_most = std::min(most, most - v);
  double best = INFINITY;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const double f3 = f3_least + (f3_most - f3_least) * i / kSteps, f4 = f4_least + (f4_most - f4_least) * j / kSteps;
      best = std::min(best, std::abs(quantity(f3, f4) - wanted));
    }
  }
  return best;
}

}  // namespace

TEST_CASE("the mixer inverts Eq 4 where the limits allow") {
  Random random(1);
  const Vehicle vehicle = oracle::paper_vehicle();
  for (int i = 0; i < 300; ++i) {
    RotorCommands f;
    for (float& thrust : f.thrust) thrust = static_cast<float>(random.uniform(-3.0, 3.0));
    const Allocation given = allocate(mix(f, vehicle), vehicle);
    for (std::size_t k = 0; k < 4; ++k) CHECK(given.rotors.thrust[k] == doctest::Approx(f.thrust[k]).epsilon(1e-5));
    CHECK(!given.cut.tilt);
  }
}

TEST_CASE("each rotor pushes where it sits: left rolls right, rear pitches down, 1 and 3 turn clockwise") {
  const Vehicle vehicle = oracle::paper_vehicle();
  const auto alone = [&](std::size_t i) {
    RotorCommands f;
    f.thrust[i] = 1.F;
    return mix(f, vehicle).torque;
  };
  CHECK(alone(0).isApprox(Vec3(0.175F, 0.F, -0.01F)));
  CHECK(alone(1).isApprox(Vec3(0.F, 0.175F, 0.01F)));
  CHECK(alone(2).isApprox(Vec3(-0.175F, 0.F, -0.01F)));
  CHECK(alone(3).isApprox(Vec3(0.F, -0.175F, 0.01F)));
}

TEST_CASE("at saturation roll and pitch come first, then thrust, then yaw, as a scan of all thrusts finds") {
  Random random(2);
  for (const Vehicle& vehicle : {oracle::paper_vehicle(), oracle::fixed_pitch_vehicle()}) {
    const double least = vehicle.thrust_min, most = vehicle.thrust_max;
    const double range = most - least;
    for (int i = 0; i < 250; ++i) {
      const Wrench wanted = random_wrench(random, 1.5);
      const Wrench given = mix(allocate(wanted, vehicle).rotors, vehicle);
      const double wanted_u = wanted.torque.x() / vehicle.arm, wanted_v = wanted.torque.y() / vehicle.arm;
      const double u = given.torque.x() / vehicle.arm, v = given.torque.y() / vehicle.arm;
      const double share = std::min(1.0, range / std::max(std::abs(wanted_u), std::abs(wanted_v)));
      CHECK(u == doctest::Approx(share * wanted_u).epsilon(1e-4));
      CHECK(v == doctest::Approx(share * wanted_v).epsilon(1e-4));

      const double thrust_error = std::abs(given.thrust - wanted.thrust);
      const double thrust_best =
          nearest(wanted.thrust, u, v, least, most, [&](double f3, double f4) { return 2.0 * (f3 + f4) + u + v; });
      CHECK(thrust_error <= thrust_best + 1e-4);

      const double wanted_y = wanted.torque.z() / vehicle.yaw_coefficient;
      const double y_error = std::abs(given.torque.z() / vehicle.yaw_coefficient - wanted_y);
      double y_best = INFINITY;  // over all rotor 3 with this very thrust
      for (int k = 0; k <= 4000; ++k) {
        const double f3 = least + range * k / 4000.0, f4 = 0.5 * (given.thrust - u - v) - f3;
        const double outside =
            std::max({least - f4, f4 - most, least - (f3 + u), f3 + u - most, least - (f4 + v), f4 + v - most});
        if (outside <= 1e-6) y_best = std::min(y_best, std::abs((2.0 * f4 + v) - (2.0 * f3 + u) - wanted_y));
      }
      if (std::isfinite(y_best)) CHECK(y_error <= y_best + 2e-4);
    }
  }
}

TEST_CASE("no rotor is ever asked beyond its limits, and flags tell what was cut") {
  Random random(3);
  const Vehicle vehicle = oracle::fixed_pitch_vehicle();
  for (const double excess : {0.1, 1.0, 10.0, 1e6, 1e30}) {
    for (int i = 0; i < 200; ++i) {
      const Wrench wanted = random_wrench(random, excess);
      const Allocation given = allocate(wanted, vehicle);
      for (const float f : given.rotors.thrust) {
        CHECK(f >= vehicle.thrust_min);
        CHECK(f <= vehicle.thrust_max);
      }
      const Wrench got = mix(given.rotors, vehicle);
      if (!given.cut.thrust) CHECK(got.thrust == doctest::Approx(wanted.thrust).epsilon(1e-4));
      if (!given.cut.tilt) CHECK((got.torque - wanted.torque).head<2>().norm() < 1e-4F);
      if (!given.cut.yaw) CHECK(std::abs(got.torque.z() - wanted.torque.z()) < 1e-5F);
    }
  }
}

TEST_CASE("a wrench that is not finite gives hover thrust without torque") {
  const Vehicle vehicle = oracle::paper_vehicle();
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    for (int field = 0; field < 4; ++field) {
      Wrench wrench{5.F, Vec3(0.1F, 0.F, 0.F)};
      (field == 3 ? wrench.thrust : wrench.torque[field]) = bad;
      const Allocation given = allocate(wrench, vehicle);
      CHECK(given.cut.tilt);
      for (const float f : given.rotors.thrust) CHECK(f == doctest::Approx(vehicle.mass * 9.81F / 4.F));
    }
  }
}

}  // namespace halfroll
