// The whole world: hover, fall, ground, determinism.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "sim/airframe.hpp"
#include "sim/sitl/scenario_file.hpp"
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

const Scenario kIdeal;

Model ideal(const Plant& plant = {}) { return {plant, kIdeal}; }
Model nominal(const Plant& plant = {}) { return {plant, sitl::make_scenario("nominal")}; }

World at(const Model& model, const RigidBody& body, const RotorCommands& commands = {}) {
  return start(model, 0, body, steady(model.plant, commands));
}

World after(const Model& model, World world, int milliseconds, const RotorCommands& commands) {
  for (int n = 0; n < milliseconds; ++n) step(model, world, commands);
  return world;
}

double mechanical_energy(const Plant& plant, const World& w) {
  const RigidBody& b = w.body;
  return 0.5 * plant.mass * b.v_WB.squaredNorm() + 0.5 * b.w_WB_B.dot(plant.inertia.cwiseProduct(b.w_WB_B)) +
         plant.mass * plant.gravity * b.p_WB.z();
}

}  // namespace

TEST_CASE("four rotors that carry the weight keep the vehicle still") {
  const Model model = ideal();
  const RotorCommands hover = all(model.plant.mass * model.plant.gravity / 4);
  const World w = after(model, at(model, at_height(1), hover), 1000, hover);
  CHECK((w.body.p_WB - Vec3d(0, 0, 1)).norm() < 1e-6);  // the command is a float32
  CHECK(w.body.v_WB.norm() < 1e-6);
  CHECK(w.readings.imu.specific_force_B.z() == doctest::Approx(model.plant.gravity));
}

TEST_CASE("an inverted vehicle hovers on negative thrust") {
  const Model model = ideal();
  const RotorCommands hover = all(-model.plant.mass * model.plant.gravity / 4);
  RigidBody body = at_height(1);
  body.q_WB = {0, 1, 0, 0};
  const World w = after(model, at(model, body, hover), 1000, hover);
  CHECK((w.body.p_WB - Vec3d(0, 0, 1)).norm() < 1e-6);
}

TEST_CASE("without thrust it falls freely and the accelerometer shows nothing") {
  const Model model = ideal();
  const World w = after(model, at(model, at_height(10)), 1000, all(0));
  CHECK(w.body.p_WB.z() == doctest::Approx(10 - 0.5 * model.plant.gravity).epsilon(1e-12));
  CHECK(w.body.v_WB.z() == doctest::Approx(-model.plant.gravity).epsilon(1e-12));
  CHECK(w.readings.imu.specific_force_B.norm() == 0.0F);
}

TEST_CASE("drag stops a drifting body as exp(-c t / m)") {
  Plant plant;
  plant.gravity = 0;
  RigidBody body = at_height(10);
  body.v_WB = {5, 0, 0};
  const Model draggy = nominal(plant);
  const World w = after(draggy, at(draggy, body), 1000, all(0));
  CHECK(w.body.v_WB.x() == doctest::Approx(5 * std::exp(-plant.drag_N_s_m / plant.mass)).epsilon(1e-12));
  CHECK(after(ideal(plant), at(ideal(plant), body), 1000, all(0)).body.v_WB.x() == 5.0);
}

TEST_CASE("a falling body with drag goes as sqrt(m g / k) tanh(t sqrt(g k / m)), to terminal velocity") {
  Plant plant;
  plant.drag_N_s_m = 0;
  plant.drag_N_s2_m2 = 0.02;
  const Model model = nominal(plant);
  const double terminal = std::sqrt(plant.mass * plant.gravity / plant.drag_N_s2_m2);
  for (const int ms : {500, 2000, 20000}) {
    const World w = after(model, at(model, at_height(1000)), ms, all(0));
    const double expected = terminal * std::tanh(1e-3 * ms * plant.gravity / terminal);
    CHECK(w.body.v_WB.z() == doctest::Approx(-expected).epsilon(1e-10));
  }
}

TEST_CASE("wind carries a drifting body along") {
  Plant plant;
  plant.gravity = 0;
  Scenario windy;
  windy.effects.drag = true;
  windy.wind.mean = {0, 3, 0};
  const Model model(plant, windy);
  const World w = after(model, at(model, at_height(10)), 60000, all(0));
  CHECK(w.body.v_WB.y() == doctest::Approx(3.0 * (1 - std::exp(-60 * plant.drag_N_s_m / plant.mass))).epsilon(1e-9));
}

TEST_CASE("a constant torque spins it up at M / J") {
  const Model model = ideal();
  const RotorCommands turn = {{-1, 1, -1, 1}};
  const World w = after(model, at(model, at_height(100), turn), 1000, turn);
  CHECK(w.body.w_WB_B.z() == doctest::Approx(4 * 0.010 / 0.0068).epsilon(1e-12));
}

TEST_CASE("climbing rotors lose thrust to the air that comes along their axis") {
  Plant plant;
  plant.rotor_inflow_N_s_m = 0.1;
  plant.gravity = 0;
  Scenario inflow;
  inflow.effects.inflow = true;
  const Model model(plant, inflow);
  // m dv/dt = 4 f - 4 k v
  const World w = after(model, at(model, at_height(10), all(1)), 3000, all(1));
  CHECK(w.body.v_WB.z() == doctest::Approx(10 * (1 - std::exp(-3 * 0.4 / plant.mass))).epsilon(1e-9));
}

TEST_CASE("rotor drag acts at the hubs: it slows sideways flight and turning") {
  Plant plant;
  plant.rotor_drag_N_s_m = 0.05;
  plant.gravity = 0;
  Scenario blades;
  blades.effects.rotor_drag = true;
  const Model model(plant, blades);
  RigidBody body = at_height(10);
  body.v_WB = {2, 0, 0};
  body.w_WB_B = {0, 0, 3};
  const World w = after(model, at(model, body), 1000, all(0));
  CHECK(w.body.v_WB.norm() == doctest::Approx(2 * std::exp(-4 * 0.05 / plant.mass)).epsilon(1e-9));
  CHECK(w.body.w_WB_B.z() == doctest::Approx(3 * std::exp(-4 * 0.05 * 0.175 * 0.175 / 0.0068)).epsilon(1e-9));
}

TEST_CASE("rotors that spin the same way make a gyroscope: it precesses at h / J") {
  Plant plant;
  plant.rotor_kind = RotorKind::kFixedPitch;
  plant.thrust_min = 0;
  plant.gravity = 0;
  plant.rotor_inertia = 1e-4;
  plant.rotor_speed_rad_s = 1000;
  plant.yaw_coefficient = 0;
  Scenario gyroscopic;
  gyroscopic.effects.gyroscopic = true;
  const Model model(plant, gyroscopic);
  RigidBody body = at_height(100);
  body.w_WB_B = {0.1, 0, 0};
  const RotorCommands left_and_right = {{3, 0, 3, 0}};  // 2 x 1e-4 x 1000 upwards: 0.2 N m s
  World w = after(model, at(model, body, left_and_right), 50, left_and_right);
  // J dw/dt = -w x h: w turns about body up at h / J = 54.8 rad/s, from x towards y as h points up
  const double angle = 0.05 * 0.2 / 0.00365;
  CHECK(w.body.w_WB_B.x() == doctest::Approx(0.1 * std::cos(angle)).epsilon(1e-6));
  CHECK(w.body.w_WB_B.y() == doctest::Approx(0.1 * std::sin(angle)).epsilon(1e-6));
}

TEST_CASE("rotors that spin up turn the body the other way: angular momentum is kept") {
  Plant plant;
  plant.rotor_kind = RotorKind::kFixedPitch;
  plant.thrust_min = 0;
  plant.gravity = 0;
  plant.rotor_inertia = 1e-4;
  plant.rotor_speed_rad_s = 1000;
  plant.yaw_coefficient = 0;
  Scenario gyroscopic;
  gyroscopic.effects.gyroscopic = true;
  const Model model(plant, gyroscopic);
  const World w = after(model, at(model, at_height(100)), 300, {{3, 0, 3, 0}});
  const double spin = 1e-4 * 1000 * (w.rotors.speed[0] + w.rotors.speed[2]);
  CHECK(spin > 0.1);
  CHECK(0.0068 * w.body.w_WB_B.z() == doctest::Approx(-spin).epsilon(1e-9));
}

TEST_CASE("close to the ground a rotor gives 1 / (1 - (R/4h)^2) times its thrust, and nothing special five radii up") {
  CHECK(ground_effect(0.12, 0.12) == doctest::Approx(1.0 / (1.0 - 1.0 / 16.0)).epsilon(0.003));
  CHECK(ground_effect(0.12, 0.6) == 1.0);
  CHECK(ground_effect(0.12, 0.01) == ground_effect(0.12, 0.06));  // bounded
  Plant plant;
  plant.rotor_radius = 0.12;
  Scenario ground;
  ground.effects.ground_effect = true;
  const Model model(plant, ground);
  const RotorCommands hover = all(plant.mass * plant.gravity / 4);
  const auto climb = [&](double z) { return after(model, at(model, at_height(z), hover), 10, hover).body.v_WB.z(); };
  CHECK(climb(0.1) > 1e-3);
  CHECK(std::abs(climb(2.0)) < 1e-8);
}

TEST_CASE("a payload adds its weight, moves the centre of mass and turns the vehicle with it") {
  const Plant plant;
  Scenario loaded;
  loaded.payload = {0.1, {0.05, 0, 0}};
  const Model model(plant, loaded);
  const double mass = plant.mass + 0.1, lever = 0.05 * 0.1 / mass;
  CHECK(model.centre.x() == doctest::Approx(lever));
  CHECK(model.inertia.moments()(1, 1) == doctest::Approx(0.00365 + plant.mass * 0.1 / mass * 0.05 * 0.05));
  const RotorCommands lift = all(mass * plant.gravity / 4);
  const World w = after(model, at(model, at_height(10), lift), 10, lift);
  CHECK(w.body.w_WB_B.y() ==
        doctest::Approx(0.01 * lever * mass * plant.gravity / model.inertia.moments()(1, 1)).epsilon(1e-4));
  // the accelerometer in the middle of the frame feels the turning, too
  const World still = at(model, at_height(10), lift);
  const double turning = lever * mass * plant.gravity / model.inertia.moments()(1, 1);
  CHECK(still.readings.imu.specific_force_B.z() == doctest::Approx(plant.gravity + turning * lever).epsilon(1e-5));
}

TEST_CASE("hover power is weight^1.5 / sqrt(2 rho A) over the figure of merit, and empties the battery in time") {
  Plant plant;
  plant.rotor_radius = 0.12;
  plant.figure_of_merit = 0.5;
  plant.battery_full_V = 12.6;
  plant.battery_empty_V = 9.9;
  plant.battery_capacity_Ah = 1.0;
  plant.battery_resistance_ohm = 0.05;
  Scenario powered;
  powered.effects.battery = true;
  const Model model(plant, powered);
  const double weight = plant.mass * plant.gravity, discs = 4 * std::acos(-1.0) * 0.12 * 0.12;
  const double expected = std::pow(weight, 1.5) / std::sqrt(2 * 1.225 * discs) / 0.5;
  const RotorCommands hover = all(weight / 4);
  World w = after(model, at(model, at_height(100), hover), 60000, hover);
  CHECK(w.battery.power == doctest::Approx(expected).epsilon(1e-6));
  // V = open - R I and P = V I
  const double open = 9.9 + w.battery.charge * 2.7;
  CHECK(w.battery.voltage == doctest::Approx(open - 0.05 * expected / w.battery.voltage).epsilon(1e-5));
  CHECK(1.0 - w.battery.charge == doctest::Approx(60 * expected / 12.5 / 3600).epsilon(0.02));
}

TEST_CASE("it stands at the origin without jitter") {
  const Model model = ideal();
  World w = start(model, 0);
  double fastest = 0;
  for (int n = 0; n < 5000; ++n) {
    step(model, w, all(0));
    fastest = std::max({fastest, w.body.v_WB.norm(), w.body.w_WB_B.norm()});
  }
  CHECK(fastest < 1e-12);
  CHECK(w.body.p_WB.norm() < 1e-12);
  CHECK(w.readings.imu.specific_force_B.z() == doctest::Approx(model.plant.gravity));
}

TEST_CASE("dropped flat or tilted, it never gains energy and comes to rest at height 0") {
  const Model model = ideal();
  for (const double tilt : {0.0, 0.3}) {
    RigidBody body = at_height(0.3);
    body.q_WB = {std::cos(tilt / 2), std::sin(tilt / 2), 0, 0};
    World w = start(model, 0, body);
    const double given = mechanical_energy(model.plant, w);
    double most = given;
    for (int n = 0; n < 5000; ++n) {
      step(model, w, all(0));
      most = std::max(most, mechanical_energy(model.plant, w));
    }
    CHECK(most < given + 1e-9);
    CHECK(std::abs(w.body.p_WB.z()) < 1e-6);
    CHECK(w.body.v_WB.norm() < 1e-6);
    CHECK(rotation(w.body.q_WB)(2, 2) == doctest::Approx(1.0));
    CHECK_FALSE(w.contact.crashed);
    CHECK(w.contact.hardest_impact > 1.5);
  }
}

TEST_CASE("a vehicle that falls on its back lies there, and has crashed") {
  const Model model = ideal();
  RigidBody body = at_height(0.5);
  body.q_WB = {0, 1, 0, 0};
  const World w = after(model, start(model, 0, body), 3000, all(0));
  CHECK(std::abs(w.body.p_WB.z()) < 1e-6);
  CHECK(rotation(w.body.q_WB)(2, 2) < -0.999);
  CHECK(w.contact.crashed);
}

TEST_CASE("it tips over when it lands beyond its balance, and not before; a hard landing is a crash") {
  const Model model = ideal();
  const auto dropped = [&](double tilt, double height) {
    RigidBody body = at_height(height);
    body.q_WB = {std::cos(tilt / 2), std::sin(tilt / 2), 0, 0};
    return after(model, start(model, 0, body), 4000, all(0));
  };
  CHECK(rotation(dropped(0.9, 0.15).body.q_WB)(2, 2) > 0.999);
  CHECK(rotation(dropped(2.0, 0.15).body.q_WB)(2, 2) < -0.999);
  CHECK(dropped(2.0, 0.15).contact.crashed);
  CHECK_FALSE(dropped(0.0, 0.4).contact.crashed);  // 2.8 m/s
  CHECK(dropped(0.0, 0.6).contact.crashed);        // 3.4 m/s
}

TEST_CASE("a push high up while a foot is caught turns it over") {
  const Model model = ideal();
  RigidBody body;
  body.v_WB = {3, 0, 0};  // slides, and its feet grip
  Plant grippy = model.plant;
  grippy.friction = 20;
  grippy.leg_height = 0.2;  // top-heavy
  grippy.foot_radius = 0.1;
  const Model tall = ideal(grippy);
  CHECK(rotation(after(model, start(model, 0, body), 3000, all(0)).body.q_WB)(2, 2) > 0.999);
  double tilt = 1;
  World w = start(tall, 0, body);
  for (int n = 0; n < 1000; ++n) step(tall, w, all(0)), tilt = std::min(tilt, rotation(w.body.q_WB)(2, 2));
  CHECK(tilt < 0.5);
}

TEST_CASE("friction holds against a turning rotor pair, does not creep, and lets go beyond its limit") {
  const auto turned = [&](const Plant& plant, float f, int milliseconds) {
    const Model model = ideal(plant);
    return std::abs(after(model, start(model, 0), milliseconds, {{-f, f, -f, f}}).body.q_WB[3]);
  };
  CHECK(turned({}, 1.0F, 10000) < 1e-3);
  CHECK(turned({}, 1.0F, 10000) - turned({}, 1.0F, 5000) < 1e-9);
  Plant ice;
  ice.friction = 0.001;
  CHECK(turned(ice, 1.0F, 1000) > 0.1);
}

TEST_CASE("a sliding vehicle stops after v^2 / (2 mu g)") {
  const Model model = ideal();
  RigidBody body;
  body.v_WB = {1, 0, 0};
  const World w = after(model, start(model, 0, body), 2000, all(0));
  CHECK(w.body.p_WB.x() == doctest::Approx(1.0 / (2 * model.plant.friction * model.plant.gravity)).epsilon(0.1));
  CHECK(w.body.v_WB.norm() < 1e-6);
}

TEST_CASE("the same seed gives the same bits, another seed does not, a copy continues identically") {
  const RotorCommands commands = {{1.5F, 1.4F, 1.5F, 1.41F}};
  for (const char* name : {"nominal", "full"}) {
    const Model model(Plant{}, sitl::make_scenario(name));
    const World w = after(model, start(model, 7), 500, commands);
    CHECK(same_state(w, after(model, start(model, 7), 500, commands)));
    CHECK_FALSE(same_state(w, after(model, start(model, 8), 500, commands)));
    CHECK(same_state(after(model, w, 500, commands), after(model, start(model, 7), 1000, commands)));
  }
}

TEST_CASE("a restarted clock counts from 0 and leaves the body alone") {
  const Model model = nominal();
  const World w = after(model, at(model, at_height(2)), 15, all(1));
  World again = w;
  restart_clock(model, again);
  CHECK(again.t_us == 0);
  CHECK(again.body.p_WB == w.body.p_WB);
}

TEST_CASE("halving the substep of a whole flight in moving air divides its error by sixteen") {
  // the world's own loads, a smooth manoeuvre: rotors as functions of time, inflow, drag, turning
  Plant plant;
  plant.rotor_inflow_N_s_m = 0.1;
  plant.rotor_drag_N_s_m = 0.02;
  plant.drag_N_s2_m2 = 0.01;
  Scenario air;
  air.effects.drag = air.effects.inflow = air.effects.rotor_drag = true;
  const Model model(plant, air);
  Surroundings around;
  around.air = air_coefficients(model, {1, 1, 1, 1});
  around.wind_W = {2, 1, 0};
  const auto flown = [&](double h) {
    RigidBody body;
    body.p_WB.z() = 10;
    double t = 0;
    const auto thrusts = [](double s) {
      return PerRotor{1.4 + 0.3 * std::sin(9 * s), 1.5, 1.4 - 0.3 * std::sin(9 * s), 1.4};
    };
    for (long n = std::lround(1.0 / h); n > 0; --n, t += h) {
      rk4(
          model.inertia, body,
          [&](const RigidBody& b, Moment m) {
            const double when = t + (m == Moment::kBegin ? 0 : m == Moment::kMiddle ? 0.5 * h : h);
            Load sum = felt_load(model, around, {}, rotor_load(model, thrusts(when)), b);
            sum.force_W.z() -= model.inertia.mass() * plant.gravity;
            return sum;
          },
          h);
    }
    return body;
  };
  const RigidBody exact = flown(1e-4);
  const auto error = [&](double h) { return (flown(h).p_WB - exact.p_WB).norm(); };
  const double order = std::log2(error(1e-2) / error(5e-3));
  MESSAGE("order ", order, ", error after 1 s at 250 us ", error(2.5e-4), " m");
  CHECK(order > 3.7);
  CHECK(order < 4.4);
}
