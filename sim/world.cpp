#include "sim/world.hpp"

namespace halfroll::sim {
namespace {

/// Everything that pushes the body, gravity excepted: what an accelerometer feels.
Load felt_load(const Plant& plant, const Scenario& scenario, const BodyLoad& rotors, const Contact& contact,
               const RigidBody& body) {
  Load sum = ground_load(plant, contact, body);
  sum.force_W += rotation(body.q_WB).col(2) * rotors.thrust;
  if (scenario.drag) sum.force_W -= plant.drag_N_s_m * body.v_WB;
  sum.torque_B += rotors.torque_B;
  return sum;
}

void measure(const Plant& plant, const Scenario& scenario, World& world) {
  const Load felt = felt_load(plant, scenario, load(plant, world.rotors), world.contact, world.body);
  const Vec3d specific_force_B = rotation(world.body.q_WB).transpose() * felt.force_W / plant.mass;
  world.readings = read(scenario, world.sensors, world.t_us, world.body, specific_force_B);
}

}  // namespace

World start(const Plant& plant, const Scenario& scenario, std::uint64_t seed, const RigidBody& body,
            const Rotors& rotors) {
  World world;
  world.body = body;
  world.rotors = rotors;
  world.sensors = make_sensors(scenario, seed);
  settle(plant, world.contact, world.body);
  measure(plant, scenario, world);
  return world;
}

World step(const Plant& plant, const Scenario& scenario, World world, const RotorCommands& commands) {
  issue(world.rotors, commands);
  for (int substep = 0; substep < kSubsteps; ++substep) {
    advance(plant, world.rotors, substep);
    const BodyLoad rotors = load(plant, world.rotors);
    const auto load_of = [&](const RigidBody& body) {
      Load sum = felt_load(plant, scenario, rotors, world.contact, body);
      sum.force_W.z() -= plant.mass * plant.gravity;
      return sum;
    };
    world.body = rk4(plant, world.body, load_of, kSubstep);
    settle(plant, world.contact, world.body);
  }
  world.t_us += kStepUs;
  measure(plant, scenario, world);
  return world;
}

World restart_clock(const Plant& plant, const Scenario& scenario, World world) {
  world.t_us = 0;
  world.sensors.delivered = world.sensors.taken;
  measure(plant, scenario, world);
  return world;
}

}  // namespace halfroll::sim
