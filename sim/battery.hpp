// The battery: what hovering costs, and what is left. Why: an empty one gives less voltage, and voltage is rotor speed.
//
// Open-circuit voltage falls linearly from full to empty; current through the resistance takes off the rest. Power is
// that of momentum theory, T^1.5 / sqrt(2 rho A) a rotor, over the figure of merit.
#pragma once
#include "sim/model.hpp"

namespace halfroll::sim {

struct Battery {
  double charge = 1.0;   // share of the capacity that is left
  double voltage = 0.0;  // [V], at the terminals; 0: none is modelled
  double power = 0.0;    // [W]
};

/// Full, no load.
inline Battery full_battery(const Model& model) { return {1.0, model.plant.battery_full_V, 0.0}; }

/// Electrical power of the four rotors [W].
inline double rotor_power(const Model& model, const PerRotor& thrust) {
  double power = 0.0;
  for (const double f : thrust) power += model.hover_power * std::abs(f) * std::sqrt(std::abs(f));
  return power;
}

/// `seconds` later at this power. What no battery can give (V² / 4R) is given as far as it goes.
inline void drain(const Model& model, Battery& battery, double power, double seconds) {
  const Plant& plant = model.plant;
  const double open = plant.battery_empty_V + battery.charge * (plant.battery_full_V - plant.battery_empty_V);
  const double under_root = std::max(0.0, open * open - 4.0 * plant.battery_resistance_ohm * power);
  battery.power = power;
  battery.voltage = 0.5 * (open + std::sqrt(under_root));
  const double ampere = power / battery.voltage;
  battery.charge = std::max(0.0, battery.charge - ampere * seconds / (3600.0 * plant.battery_capacity_Ah));
}

/// Share of nominal speed that this voltage allows a rotor.
inline double speed_ceiling(const Model& model, const Battery& battery) {
  const double full = model.plant.battery_full_V;
  if (full <= 0.0) return 1.0;
  const double needed = full * (model.rotors.variable_pitch ? 1.0 - model.plant.governor_headroom : 1.0);
  return std::min(1.0, battery.voltage / needed);
}

}  // namespace halfroll::sim
