// Rotor dynamics, against the times measured on the paper's vehicle.
#include <doctest/doctest.h>

#include <cmath>

#include "sim/rotors.hpp"

using namespace halfroll;
using namespace halfroll::sim;

namespace {

RotorCommands all(double thrust) {
  const auto f = static_cast<float>(thrust);
  return {{f, f, f, f}};
}

Plant fixed_pitch() {
  Plant plant;
  plant.rotor_kind = RotorKind::kFixedPitch;
  plant.thrust_min = 0.15;
  plant.rotor_delay = 0.0;
  plant.rotor_lag = plant.rotor_lag_down = 0.12;
  return plant;
}

/// Time [s] from the step in command until `done(thrust)`.
template <typename Done>
double time_until(const Plant& plant, double from, double to, const Done& done) {
  Rotors rotors = steady(all(from));
  for (int n = 0; n < 10000; ++n) {
    if (n % kSubsteps == 0) issue(rotors, all(to));
    advance(plant, rotors, n % kSubsteps);
    if (done(rotors.thrust[0])) return (n + 1) * kSubstep;
  }
  return 1e9;
}

}  // namespace

TEST_CASE("a variable-pitch rotor rises from 10 to 90 % in 0.0396 s") {
  const auto reaches = [](double level) { return time_until(Plant{}, 0.0, 1.0, [=](double f) { return f >= level; }); };
  CHECK(reaches(0.9) - reaches(0.1) == doctest::Approx(0.0396).epsilon(0.01));  // one substep is 0.6 %
}

TEST_CASE("a variable-pitch rotor reverses from -3 to 3 N within 5 % in 0.069 s") {
  const double t = time_until(Plant{}, -3.0, 3.0, [](double f) { return f >= 3.0 - 0.05 * 6.0; });
  CHECK(t == doctest::Approx(0.069).epsilon(0.01));
}

TEST_CASE("a variable-pitch command does nothing for 3 ms") {
  const double t = time_until(Plant{}, 0.0, 1.0, [](double f) { return f != 0.0; });
  CHECK(t == doctest::Approx(0.003 + kSubstep));
}

TEST_CASE("a dead time between two milliseconds is kept to a substep") {
  Plant plant;
  plant.rotor_delay = 0.0025;
  CHECK(time_until(plant, 0.0, 1.0, [](double f) { return f != 0.0; }) == doctest::Approx(0.0025 + kSubstep));
  plant.rotor_delay = kLongestRotorDelay;
  const double t = time_until(plant, 0.0, 1.0, [](double f) { return f != 0.0; });
  CHECK(t == doctest::Approx(kLongestRotorDelay + kSubstep));
}

TEST_CASE("a fixed-pitch motor rises from 10 to 90 % of its speed in 0.264 s") {
  const auto reaches = [](double speed) {
    return time_until(fixed_pitch(), 0.0, 1.0, [=](double f) { return std::sqrt(f) >= speed; });
  };
  CHECK(reaches(0.9) - reaches(0.1) == doctest::Approx(0.264).epsilon(0.01));
}

TEST_CASE("a fixed-pitch motor falls with a lag of its own") {
  Plant plant = fixed_pitch();
  plant.rotor_lag_down = 0.2;
  const double t = time_until(plant, 1.0, 0.0, [](double f) { return std::sqrt(f) <= std::exp(-1.0); });
  CHECK(t == doctest::Approx(0.2).epsilon(0.01));
}

TEST_CASE("a fixed-pitch rotor stops when commanded 0 and never pushes down") {
  CHECK(time_until(fixed_pitch(), 1.0, 0.0, [](double f) { return f < 1e-6; }) < 2.0);
  CHECK(time_until(fixed_pitch(), 1.0, -3.0, [](double f) { return f < 0.0; }) > 1e8);
}

TEST_CASE("no rotor gives more than its limit") {
  CHECK(time_until(Plant{}, 0.0, 9.0, [](double f) { return f > 3.0; }) > 1e8);
  CHECK(time_until(Plant{}, 0.0, -9.0, [](double f) { return f < -3.0; }) > 1e8);
}

TEST_CASE("an ideal rotor obeys at once") {
  Plant plant;
  plant.ideal_rotors = true;
  CHECK(time_until(plant, 0.0, 1.0, [](double f) { return f == 1.0; }) == kSubstep);
}

TEST_CASE("left rotor rolls right wing down, rear rotor pitches nose down, rear and front turn left") {
  const auto torque = [](std::array<float, 4> f) { return load(Plant{}, steady({f})).torque_B; };
  CHECK(torque({1, 0, 0, 0}).x() == doctest::Approx(0.175));
  CHECK(torque({0, 1, 0, 0}).y() == doctest::Approx(0.175));
  CHECK(torque({0, 0, 1, 0}).x() == doctest::Approx(-0.175));
  CHECK(torque({0, 0, 0, 1}).y() == doctest::Approx(-0.175));
  CHECK((torque({0, 1, 0, 1}) - Vec3d(0, 0, 0.02)).norm() < 1e-12);
  CHECK((torque({1, 0, 1, 0}) + Vec3d(0, 0, 0.02)).norm() < 1e-12);
}
