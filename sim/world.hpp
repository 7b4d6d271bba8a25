// The world, one millisecond at a time. Why: a flight is a value. A copied World flies the same future; two Worlds of
// the same seed under the same commands are equal in every bit.
//
//   World w = start(plant, scenario, seed);
//   loop: commands = autopilot.step(w.readings);  w = step(plant, scenario, w, commands);
#pragma once
#include "sim/contact.hpp"
#include "sim/plant.hpp"
#include "sim/rigid_body.hpp"
#include "sim/rotors.hpp"
#include "sim/scenario.hpp"
#include "sim/sensors.hpp"

namespace halfroll::sim {

/// Truth (body, rotors) and what is measured of it (readings) at t_us.
struct World {
  std::uint64_t t_us = 0;
  RigidBody body;
  Rotors rotors;
  Contact contact;
  Sensors sensors;
  Measurements readings;
};

/// At time 0: standing at the origin with rotors at rest, or wherever `body` and `rotors` say.
World start(const Plant& plant, const Scenario& scenario, std::uint64_t seed, const RigidBody& body = {},
            const Rotors& rotors = {});

/// One millisecond later, in kSubsteps steps; the commands hold from now on.
World step(const Plant& plant, const Scenario& scenario, World world, const RotorCommands& commands);

/// Time counts from 0 again; poses on their way are lost. For an autopilot that restarts while the world goes on.
World restart_clock(const Plant& plant, const Scenario& scenario, World world);

}  // namespace halfroll::sim
