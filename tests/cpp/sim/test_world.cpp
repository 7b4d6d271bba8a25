// The whole world: hover, fall, ground, determinism.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "sim/world.hpp"

using namespace halfroll;
using namespace halfroll::sim;

namespace {

RotorCommands all(double thrust) {
  const auto f = static_cast<float>(thrust);
  return {{f, f, f, f}};
}

RigidBody at_height(double z) {
  RigidBody body;
  body.p_WB = {0.0, 0.0, z};
  return body;
}

World after(const Plant& plant, World world, int milliseconds, const RotorCommands& commands,
            const Scenario& scenario = kIdeal) {
  for (int n = 0; n < milliseconds; ++n) world = step(plant, scenario, world, commands);
  return world;
}

double mechanical_energy(const Plant& plant, const World& w) {
  const RigidBody& b = w.body;
  return 0.5 * plant.mass * b.v_WB.squaredNorm() + 0.5 * b.w_WB_B.dot(plant.inertia.cwiseProduct(b.w_WB_B)) +
         plant.mass * plant.gravity * b.p_WB.z();
}

bool same(const World& a, const World& b) {
  return a.body.p_WB == b.body.p_WB && a.body.v_WB == b.body.v_WB && a.body.q_WB == b.body.q_WB &&
         a.body.w_WB_B == b.body.w_WB_B && a.rotors.thrust == b.rotors.thrust &&
         a.sensors.noise.state == b.sensors.noise.state && a.readings.imu.w_WB_B == b.readings.imu.w_WB_B &&
         a.readings.pose.has_value() == b.readings.pose.has_value();
}

}  // namespace

TEST_CASE("four rotors that carry the weight keep the vehicle still") {
  const Plant plant;
  const RotorCommands hover = all(plant.mass * plant.gravity / 4);
  const World w = after(plant, start(plant, kIdeal, 0, at_height(1), steady(hover)), 1000, hover);
  CHECK((w.body.p_WB - Vec3d(0, 0, 1)).norm() < 1e-6);  // the command is a float32
  CHECK(w.body.v_WB.norm() < 1e-6);
  CHECK(w.readings.imu.specific_force_B.z() == doctest::Approx(plant.gravity));
}

TEST_CASE("an inverted vehicle hovers on negative thrust") {
  const Plant plant;
  const RotorCommands hover = all(-plant.mass * plant.gravity / 4);
  RigidBody body = at_height(1);
  body.q_WB = {0, 1, 0, 0};
  const World w = after(plant, start(plant, kIdeal, 0, body, steady(hover)), 1000, hover);
  CHECK((w.body.p_WB - Vec3d(0, 0, 1)).norm() < 1e-6);
}

TEST_CASE("without thrust it falls freely and the accelerometer shows nothing") {
  const Plant plant;
  const World w = after(plant, start(plant, kIdeal, 0, at_height(10)), 1000, all(0));
  CHECK(w.body.p_WB.z() == doctest::Approx(10 - 0.5 * plant.gravity).epsilon(1e-12));
  CHECK(w.body.v_WB.z() == doctest::Approx(-plant.gravity).epsilon(1e-12));
  CHECK(w.readings.imu.specific_force_B.norm() == 0.0F);
}

TEST_CASE("drag stops a drifting body as exp(-c t / m)") {
  Plant plant;
  plant.gravity = 0;
  RigidBody body = at_height(10);
  body.v_WB = {5, 0, 0};
  const World w = after(plant, start(plant, kNominal, 0, body), 1000, all(0), kNominal);
  CHECK(w.body.v_WB.x() == doctest::Approx(5 * std::exp(-plant.drag_N_s_m / plant.mass)).epsilon(1e-12));
  CHECK(after(plant, start(plant, kIdeal, 0, body), 1000, all(0)).body.v_WB.x() == 5.0);
}

TEST_CASE("it stands at the origin without jitter") {
  const Plant plant;
  World w = start(plant, kIdeal, 0);
  double fastest = 0;
  for (int n = 0; n < 5000; ++n) {
    w = step(plant, kIdeal, w, all(0));
    fastest = std::max({fastest, w.body.v_WB.norm(), w.body.w_WB_B.norm()});
  }
  CHECK(fastest < 1e-12);
  CHECK(w.body.p_WB.norm() < 1e-12);
  CHECK(w.readings.imu.specific_force_B.z() == doctest::Approx(plant.gravity));
}

TEST_CASE("dropped flat or tilted, it never gains energy and comes to rest at height 0") {
  const Plant plant;
  for (const double tilt : {0.0, 0.3}) {
    RigidBody body = at_height(0.3);
    body.q_WB = {std::cos(tilt / 2), std::sin(tilt / 2), 0, 0};
    World w = start(plant, kIdeal, 0, body);
    const double given = mechanical_energy(plant, w);
    double most = given;
    for (int n = 0; n < 5000; ++n) {
      w = step(plant, kIdeal, w, all(0));
      most = std::max(most, mechanical_energy(plant, w));
    }
    CHECK(most < given + 1e-9);
    CHECK(std::abs(w.body.p_WB.z()) < 1e-6);
    CHECK(w.body.v_WB.norm() < 1e-6);
    CHECK(rotation(w.body.q_WB)(2, 2) == doctest::Approx(1.0));
  }
}

TEST_CASE("a vehicle that falls on its back lies there") {
  const Plant plant;
  RigidBody body = at_height(0.5);
  body.q_WB = {0, 1, 0, 0};
  const World w = after(plant, start(plant, kIdeal, 0, body), 3000, all(0));
  CHECK(std::abs(w.body.p_WB.z()) < 1e-6);
  CHECK(rotation(w.body.q_WB)(2, 2) < -0.999);
}

TEST_CASE("friction holds against a turning rotor pair, does not creep, and lets go beyond its limit") {
  const Plant plant;
  const auto turned = [&](float f, int milliseconds) {
    const World w = after(plant, start(plant, kIdeal, 0), milliseconds, {{-f, f, -f, f}});
    return std::abs(w.body.q_WB[3]);
  };
  CHECK(turned(1.0F, 10000) < 1e-3);
  CHECK(turned(1.0F, 10000) - turned(1.0F, 5000) < 1e-9);
  Plant ice = plant;
  ice.friction = 0.001;
  CHECK(std::abs(after(ice, start(ice, kIdeal, 0), 1000, {{-1, 1, -1, 1}}).body.q_WB[3]) > 0.1);
}

TEST_CASE("a sliding vehicle stops after v^2 / (2 mu g)") {
  const Plant plant;
  RigidBody body;
  body.v_WB = {1, 0, 0};
  const World w = after(plant, start(plant, kIdeal, 0, body), 2000, all(0));
  CHECK(w.body.p_WB.x() == doctest::Approx(1.0 / (2 * plant.friction * plant.gravity)).epsilon(0.1));
  CHECK(w.body.v_WB.norm() < 1e-6);
}

TEST_CASE("the same seed gives the same bits, another seed does not, a copy continues identically") {
  const Plant plant;
  const RotorCommands commands = {{1.5F, 1.4F, 1.5F, 1.41F}};
  const World w = after(plant, start(plant, kNominal, 7), 500, commands, kNominal);
  CHECK(same(w, after(plant, start(plant, kNominal, 7), 500, commands, kNominal)));
  CHECK_FALSE(same(w, after(plant, start(plant, kNominal, 8), 500, commands, kNominal)));
  const World copy = w;
  CHECK(same(after(plant, w, 500, commands, kNominal), after(plant, copy, 500, commands, kNominal)));
}

TEST_CASE("a restarted clock counts from 0 and leaves the body alone") {
  const Plant plant;
  const World w = after(plant, start(plant, kNominal, 0, at_height(2)), 15, all(1), kNominal);
  const World again = restart_clock(plant, kNominal, w);
  CHECK(again.t_us == 0);
  CHECK(again.body.p_WB == w.body.p_WB);
}
