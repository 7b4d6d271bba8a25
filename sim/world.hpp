// The world, one millisecond at a time. Why: a flight is a value. A copied World flies the same future; two Worlds of
// the same seed under the same commands are equal in every bit.
//
//   const Model model(plant, scenario);
//   World w = start(model, seed);
//   loop: commands = autopilot.step(w.readings);  step(model, w, commands);
#pragma once
#include "sim/battery.hpp"
#include "sim/contact.hpp"
#include "sim/model.hpp"
#include "sim/sensors.hpp"

namespace halfroll::sim {

/// Truth and what is measured of it (readings) at t_us. The body's place is that of the common centre of mass.
struct World {
  std::uint64_t t_us = 0;
  Random random;
  RigidBody body;
  Rotors rotors;
  Contact contact;
  Wind wind;
  Battery battery;
  Sensors sensors;
  Measurements readings;
};

/// At time 0: standing at the origin with rotors at rest, or wherever `body` and `rotors` say.
World start(const Model& model, std::uint64_t seed, const RigidBody& body, const Rotors& rotors);
World start(const Model& model, std::uint64_t seed, const RigidBody& body = {});

/// One millisecond later, in kSubsteps steps; the commands hold from now on.
void step(const Model& model, World& world, const RotorCommands& commands);

/// Time counts from 0 again; poses on their way are lost. For an autopilot that restarts while the world goes on.
void restart_clock(const Model& model, World& world);

/// Equal in every bit that the future depends on.
bool same_state(const World& a, const World& b);

}  // namespace halfroll::sim
