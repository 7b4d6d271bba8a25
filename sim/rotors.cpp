#include "sim/rotors.hpp"

#include <algorithm>
#include <cmath>

#include "sim/lag.hpp"
#include "sim/wide.hpp"

namespace halfroll::sim {
namespace {

constexpr double kBladeArrived = 0.1;  // of the stiction: close enough for a moving blade to stop

RotorModel::Share shares(double lag) { return {covered(0.5 * kSubstep, lag), covered(kSubstep, lag)}; }

/// The commands that reach the rotors now, having left the delay ago.
const RotorCommands& arrived(const RotorModel& model, const Rotors& rotors, int substep) {
  const int late = model.delay_substeps - substep;
  const std::size_t back = late > 0 ? static_cast<std::size_t>((late + kSubsteps - 1) / kSubsteps) : 0;
  return rotors.issued[(rotors.newest - back) % kRememberedCommands];
}

/// Blades stick: at rest they stay until far enough from where they should be.
bool sticks(const RotorModel& model, bool& moving, double error) {
  if (model.stiction_N <= 0.0) return false;
  moving = std::abs(error) > (moving ? kBladeArrived : 1.0) * model.stiction_N;
  return !moving;
}

struct Step {
  double middle, end;
};

Step towards(double from, double to, const RotorModel::Share& share) {
  return {from + share.half * (to - from), from + share.whole * (to - from)};
}

/// As std::clamp, in two instructions.
double within(double x, double lowest, double highest) { return std::max(lowest, std::min(x, highest)); }

Step blade_step(const RotorModel& model, double pitch, double wanted) {
  const double way = wanted - pitch;
  return {pitch + within(model.lag.half * way, -model.slew.half, model.slew.half),
          pitch + within(model.lag.whole * way, -model.slew.whole, model.slew.whole)};
}

}  // namespace

RotorModel::RotorModel(const Plant& plant)
    : variable_pitch(plant.rotor_kind == RotorKind::kVariablePitch),
      ideal(plant.ideal_rotors),
      delay_substeps(static_cast<int>(std::lround(plant.rotor_delay / kSubstep))),
      thrust_min(plant.thrust_min),
      thrust_max(plant.thrust_max),
      lag(shares(plant.rotor_lag)),
      lag_down(shares(plant.rotor_lag_down)),
      governor(shares(plant.governor_lag)),
      slew{0.5 * plant.rotor_slew_N_s * kSubstep, plant.rotor_slew_N_s * kSubstep},
      stiction_N(plant.servo_stiction_N),
      droop_per_N(plant.governor_droop / plant.thrust_max),
      governed(plant.governor_droop > 0.0) {}

Rotors steady(const Plant& plant, const RotorCommands& commands) {
  Rotors rotors;
  rotors.issued.fill(commands);
  const bool variable_pitch = plant.rotor_kind == RotorKind::kVariablePitch;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto thrust = static_cast<double>(commands.thrust[i]);
    rotors.thrust[i] = thrust;
    const double droop = plant.governor_droop * std::abs(thrust) / plant.thrust_max;
    rotors.speed[i] = variable_pitch ? 1.0 - droop : std::sqrt(std::max(0.0, thrust) / plant.thrust_max);
    rotors.pitch[i] = variable_pitch ? thrust / (rotors.speed[i] * rotors.speed[i]) : 0.0;
  }
  return rotors;
}

void issue(Rotors& rotors, const RotorCommands& commands) {
  rotors.newest = (rotors.newest + 1) % kRememberedCommands;
  rotors.issued[rotors.newest] = commands;
}

HALFROLL_WIDE ThrustHistory advance(const RotorModel& model, Rotors& rotors, int substep,
                                    const RotorCondition& condition) {
  const RotorCommands& command = model.ideal ? rotors.issued[rotors.newest] : arrived(model, rotors, substep);
  ThrustHistory thrust;
  if (model.plain_blades() && condition.sound) {  // most flights: the same as below, without its questions
    for (std::size_t i = 0; i < 4; ++i) {
      const auto asked = static_cast<double>(command.thrust[i]);
      const Step pitch = blade_step(model, rotors.pitch[i], within(asked, model.thrust_min, model.thrust_max));
      thrust.middle[i] = pitch.middle;
      rotors.pitch[i] = rotors.thrust[i] = thrust.end[i] = pitch.end;
    }
    return thrust;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const auto asked = static_cast<double>(command.thrust[i]);
    if (model.variable_pitch) {
      const double wanted = within(asked, model.thrust_min, model.thrust_max);
      Step pitch = {wanted, wanted};
      if (!model.ideal) pitch = blade_step(model, rotors.pitch[i], wanted);
      bool moving = rotors.blade_moving[i];
      if (condition.stuck[i] || sticks(model, moving, wanted - rotors.pitch[i])) {
        pitch = {rotors.pitch[i], rotors.pitch[i]};
      }
      rotors.blade_moving[i] = moving;
      rotors.pitch[i] = pitch.end;
      thrust.middle[i] = pitch.middle;
      thrust.end[i] = pitch.end;
      if (model.governed || !condition.sound) {
        const double load = model.droop_per_N * std::abs(rotors.thrust[i]);
        const double target = condition.dead[i] ? 0.0 : std::min(1.0 - load, condition.speed_ceiling);
        const Step speed = towards(rotors.speed[i], target, model.governor);
        rotors.speed[i] = speed.end;
        thrust.middle[i] *= speed.middle * speed.middle;
        thrust.end[i] *= speed.end * speed.end;
      }
    } else {
      // a motor that is commanded nothing stops; one that runs has a least speed
      const double wanted = asked > 0.0 ? std::clamp(asked, std::max(0.0, model.thrust_min), model.thrust_max) : 0.0;
      if (model.ideal) {
        thrust.middle[i] = thrust.end[i] = wanted;
        continue;
      }
      double target = std::min(std::sqrt(wanted / model.thrust_max), condition.speed_ceiling);
      if (condition.dead[i]) target = 0.0;
      if (condition.stuck[i]) target = rotors.speed[i];
      const Step speed = towards(rotors.speed[i], target, target > rotors.speed[i] ? model.lag : model.lag_down);
      rotors.speed[i] = speed.end;
      thrust.middle[i] = model.thrust_max * speed.middle * speed.middle;
      thrust.end[i] = model.thrust_max * speed.end * speed.end;
    }
    if (!condition.sound) {
      thrust.middle[i] *= condition.share[i];
      thrust.end[i] *= condition.share[i];
    }
  }
  rotors.thrust = thrust.end;
  return thrust;
}

}  // namespace halfroll::sim
