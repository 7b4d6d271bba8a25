// Rotor dynamics, against the times measured on the paper's vehicle.
#include <doctest/doctest.h>

#include <cmath>

#include "sim/model.hpp"

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
double time_until(const Plant& plant, double from, double to, const Done& done, const RotorCondition& condition = {}) {
  Rotors rotors = steady(plant, all(from));
  const RotorModel model(plant);
  for (int n = 0; n < 10000; ++n) {
    if (n % kSubsteps == 0) issue(rotors, all(to));
    advance(model, rotors, n % kSubsteps, condition);
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

TEST_CASE("a fixed-pitch rotor that runs is never slower than at its least thrust") {
  double slowest = 1e9;
  time_until(fixed_pitch(), 1.0, 0.001, [&](double f) { return slowest = std::min(slowest, f), false; });
  CHECK(slowest == doctest::Approx(0.15).epsilon(1e-6));
}

TEST_CASE("a weak rotor gives its share, a stuck one what it gave, a dead one nothing after a while") {
  RotorCondition weak, stuck, dead;
  weak.sound = stuck.sound = dead.sound = false;
  weak.share = {0.85, 1, 1, 1};
  stuck.stuck = {true, false, false, false};
  dead.dead = {true, false, false, false};
  for (const Plant& plant : {Plant{}, fixed_pitch()}) {
    CHECK(time_until(plant, 1.0, 2.0, [](double f) { return f > 1.69; }, weak) < 1.0);
    CHECK(time_until(plant, 1.0, 2.0, [](double f) { return f > 1.71; }, weak) > 1e8);
    CHECK(time_until(plant, 1.0, 2.0, [](double f) { return std::abs(f - 1.0) > 1e-6; }, stuck) > 1e8);
    CHECK(time_until(plant, 1.0, 2.0, [](double f) { return f < 1e-3; }, dead) < 0.6);
  }
}

TEST_CASE("a governor lets the speed droop with the load, and thrust falls with its square") {
  Plant plant;
  plant.governor_droop = 0.1;
  RotorModel model(plant);
  Rotors rotors = steady(plant, all(0.0));
  for (int n = 0; n < 8000; ++n) {
    if (n % kSubsteps == 0) issue(rotors, all(3.0));
    advance(model, rotors, n % kSubsteps, {});
  }
  // speed = 1 - 0.1 f / 3 and f = 3 speed^2
  CHECK(rotors.speed[0] == doctest::Approx(1.0 - 0.1 * rotors.thrust[0] / 3.0).epsilon(1e-9));
  CHECK(rotors.thrust[0] == doctest::Approx(3.0 * rotors.speed[0] * rotors.speed[0]).epsilon(1e-9));
}

TEST_CASE("low voltage takes thrust from the top, not from hover") {
  RotorCondition low;
  low.sound = false;
  low.speed_ceiling = 0.9;
  Plant fixed = fixed_pitch();
  CHECK(time_until(fixed, 1.0, 3.0, [](double f) { return f > 0.82 * 3.0; }, low) > 1e8);
  CHECK(time_until(fixed, 1.0, 1.4, [](double f) { return f > 1.39; }, low) < 1.0);
}

TEST_CASE("blades stick within the dead band and then go all the way") {
  Plant plant;
  plant.servo_stiction_N = 0.05;
  CHECK(time_until(plant, 1.0, 1.04, [](double f) { return f != 1.0; }) > 1e8);
  CHECK(time_until(plant, 1.0, 1.2, [](double f) { return f > 1.194; }) < 0.2);
}

TEST_CASE("drag torque is c f by default, and keeps its sign as physics has it") {
  Plant plant;
  plant.profile_torque = 0.004;
  Scenario physical;
  physical.effects.physical_torque = true;
  const auto yaw = [&](const Scenario& s, PerRotor f) { return rotor_load(Model(plant, s), f).torque_B.z(); };
  CHECK(yaw(Scenario{}, {0, -1, 0, -1}) == doctest::Approx(-0.02));
  CHECK(yaw(physical, {0, -1, 0, -1}) == doctest::Approx(0.02));
  CHECK(yaw(physical, {1, 1, 1, 1}) == doctest::Approx(0.0));
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
  const auto torque = [](PerRotor f) { return rotor_load(Model(Plant{}, Scenario{}), f).torque_B; };
  CHECK(torque({1, 0, 0, 0}).x() == doctest::Approx(0.175));
  CHECK(torque({0, 1, 0, 0}).y() == doctest::Approx(0.175));
  CHECK(torque({0, 0, 1, 0}).x() == doctest::Approx(-0.175));
  CHECK(torque({0, 0, 0, 1}).y() == doctest::Approx(-0.175));
  CHECK((torque({0, 1, 0, 1}) - Vec3d(0, 0, 0.02)).norm() < 1e-12);
  CHECK((torque({1, 0, 1, 0}) + Vec3d(0, 0, 0.02)).norm() < 1e-12);
}
