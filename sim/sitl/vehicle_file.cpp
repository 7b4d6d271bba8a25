#include "sim/sitl/vehicle_file.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "sim/rotors.hpp"
#include "sim/sitl/numbers.hpp"

namespace halfroll::sitl {
namespace {

using Numbers = std::map<std::string, double>;

const std::map<std::string, Numbers>& shipped() {
#define VEHICLE(name, ...) {name, {__VA_ARGS__}},
  static const std::map<std::string, Numbers> vehicles = {
#include "vehicles/shipped_vehicles.inc"
  };
#undef VEHICLE
  return vehicles;
}

struct Row {
  const char* key;
  double least, most;
};
constexpr std::array<Row, 32> kRows = {{{"mass_kg", 0.001, 1000.0},
                                        {"inertia_kg_m2.0", 1e-9, 1000.0},
                                        {"inertia_kg_m2.1", 1e-9, 1000.0},
                                        {"inertia_kg_m2.2", 1e-9, 1000.0},
                                        {"arm_m", 0.001, 10.0},
                                        {"yaw_coefficient_m", 1e-6, 1.0},
                                        {"drag_N_s_m", 0.0, 100.0},
                                        {"drag_N_s2_m2", 0.0, 100.0},
                                        {"speed_max_m_s", 0.001, 1000.0},
                                        {"body_rate_max_rad_s", 0.001, 1000.0},
                                        {"rotor.kind", 0.0, 1.0},
                                        {"rotor.thrust_min_N", -1000.0, 1000.0},
                                        {"rotor.thrust_max_N", 0.001, 1000.0},
                                        {"rotor.delay_s", 0.0, sim::kLongestRotorDelay},
                                        {"rotor.lag_s", 0.0, 2.0},
                                        {"rotor.lag_down_s", 0.0, 2.0},
                                        {"rotor.slew_N_s", 0.001, 1e9},
                                        {"rotor.stiction_N", 0.0, 100.0},
                                        {"rotor.radius_m", 0.0, 10.0},
                                        {"rotor.inertia_kg_m2", 0.0, 100.0},
                                        {"rotor.speed_rad_s", 0.0, 1e5},
                                        {"rotor.inflow_N_s_m", 0.0, 100.0},
                                        {"rotor.drag_N_s_m", 0.0, 100.0},
                                        {"rotor.profile_torque_N_m", 0.0, 100.0},
                                        {"rotor.figure_of_merit", 0.0, 1.0},
                                        {"rotor.governor_droop", 0.0, 0.5},
                                        {"rotor.governor_lag_s", 0.0, 10.0},
                                        {"rotor.governor_headroom", 0.0, 0.9},
                                        {"battery.full_V", 0.0, 1000.0},
                                        {"battery.empty_V", 0.0, 1000.0},
                                        {"battery.capacity_Ah", 1e-3, 1e4},
                                        {"battery.resistance_ohm", 0.0, 100.0}}};

std::string listed(const std::string& sum, const std::string& next) { return sum.empty() ? next : sum + ", " + next; }

std::string known_keys() {
  std::string keys;
  for (const Row& row : kRows) keys = listed(keys, row.key);
  return listed(keys, "params.NAME");
}

void check_param(const std::string& key, double wanted) {
  const std::string id = key.substr(std::string("params.").size());
  const int index = find_param(id.c_str());
  Params scratch;
  switch (set_param(scratch, index, static_cast<float>(wanted), false)) {
    case ParamError::kNone: return;
    case ParamError::kUnknown: throw BadOption("--set " + key + ": the autopilot has no parameter " + id);
    case ParamError::kOutOfRange: {
      const ParamInfo& info = kParamTable[static_cast<std::size_t>(index)];
      throw BadOption("--set " + key + " " + shown(wanted) + " is outside " + shown(static_cast<double>(info.least)) +
                      " to " + shown(static_cast<double>(info.most)) +
                      ((info.flags & kWhole) ? ", whole numbers" : ""));
    }
    default: throw BadOption("--set " + key + ": the parameter is read-only");
  }
}

double checked(const std::string& key, const std::string& text) {
  const std::string what = "--set " + key;
  if (key == "rotor.kind" && text == "variable-pitch") return 0.0;
  if (key == "rotor.kind" && text == "fixed-pitch") return 1.0;
  if (key.rfind("params.", 0) == 0) {
    const double wanted = number(what, text, -1e9, 1e9);
    check_param(key, wanted);
    return wanted;
  }
  const auto row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return key == r.key; });
  if (row == kRows.end()) throw BadOption(what + ": no such key; there are " + known_keys());
  return number(what, text, row->least, row->most);
}

/// What no single number shows.
void check_flyable(const std::string& name, Numbers& n) {
  const double thrust_max = n["rotor.thrust_max_N"], weight = n["mass_kg"] * static_cast<double>(kGravity);
  if (4 * thrust_max < 1.2 * weight) {
    throw BadOption("vehicle " + name + " cannot hover: four rotors of " + shown(thrust_max) + " N lift " +
                    shown(4 * thrust_max) + " N, it needs 1.2 times its weight, " + shown(1.2 * weight) + " N");
  }
  if (n["rotor.thrust_min_N"] >= thrust_max) {
    throw BadOption("vehicle " + name + ": rotor.thrust_min_N " + shown(n["rotor.thrust_min_N"]) +
                    " must be below rotor.thrust_max_N " + shown(thrust_max));
  }
  if (n["rotor.kind"] == 1.0 && n["rotor.thrust_min_N"] < 0.0) {
    throw BadOption("vehicle " + name + ": fixed-pitch rotors cannot push down, rotor.thrust_min_N " +
                    shown(n["rotor.thrust_min_N"]) + " must be 0 or more");
  }
  const double x = n["inertia_kg_m2.0"], y = n["inertia_kg_m2.1"], z = n["inertia_kg_m2.2"];
  if (2 * std::max({x, y, z}) > (x + y + z) * (1 + 1e-9)) {
    throw BadOption("vehicle " + name + ": no body has inertia " + shown(x) + ", " + shown(y) + ", " + shown(z) +
                    "; the largest may not exceed the sum of the others");
  }
}

Vehicle firmware_vehicle(Numbers& n) {
  const auto f = [&](const char* key) { return static_cast<float>(n[key]); };
  Vehicle v;
  v.mass = f("mass_kg");
  v.inertia = {f("inertia_kg_m2.0"), f("inertia_kg_m2.1"), f("inertia_kg_m2.2")};
  v.arm = f("arm_m");
  v.yaw_coefficient = f("yaw_coefficient_m");
  v.rotor_kind = n["rotor.kind"] == 1.0 ? RotorKind::kFixedPitch : RotorKind::kVariablePitch;
  v.thrust_min = f("rotor.thrust_min_N");
  v.thrust_max = f("rotor.thrust_max_N");
  v.rotor_lag = f("rotor.lag_s");
  v.rotor_lag_down = f("rotor.lag_down_s");
  return v;
}

sim::Plant plant_of(Numbers& n) {
  sim::Plant p;
  p.mass = n["mass_kg"];
  p.inertia = {n["inertia_kg_m2.0"], n["inertia_kg_m2.1"], n["inertia_kg_m2.2"]};
  p.arm = n["arm_m"];
  p.yaw_coefficient = n["yaw_coefficient_m"];
  p.drag_N_s_m = n["drag_N_s_m"];
  p.rotor_kind = n["rotor.kind"] == 1.0 ? RotorKind::kFixedPitch : RotorKind::kVariablePitch;
  p.thrust_min = n["rotor.thrust_min_N"];
  p.thrust_max = n["rotor.thrust_max_N"];
  p.rotor_delay = n["rotor.delay_s"];
  p.rotor_lag = n["rotor.lag_s"];
  p.rotor_lag_down = n["rotor.lag_down_s"];
  p.rotor_slew_N_s = n["rotor.slew_N_s"];
  // what a vehicle file need not have
  const auto take = [&n](const char* key, double& into) {
    if (const auto found = n.find(key); found != n.end()) into = found->second;
  };
  take("drag_N_s2_m2", p.drag_N_s2_m2);
  take("rotor.stiction_N", p.servo_stiction_N);
  take("rotor.radius_m", p.rotor_radius);
  take("rotor.inertia_kg_m2", p.rotor_inertia);
  take("rotor.speed_rad_s", p.rotor_speed_rad_s);
  take("rotor.inflow_N_s_m", p.rotor_inflow_N_s_m);
  take("rotor.drag_N_s_m", p.rotor_drag_N_s_m);
  take("rotor.profile_torque_N_m", p.profile_torque);
  take("rotor.figure_of_merit", p.figure_of_merit);
  take("rotor.governor_droop", p.governor_droop);
  take("rotor.governor_lag_s", p.governor_lag);
  take("rotor.governor_headroom", p.governor_headroom);
  take("battery.full_V", p.battery_full_V);
  take("battery.empty_V", p.battery_empty_V);
  take("battery.capacity_Ah", p.battery_capacity_Ah);
  take("battery.resistance_ohm", p.battery_resistance_ohm);
  return sim::with_fitting_legs(p);
}

}  // namespace

VehicleSetup make_vehicle(const std::string& name, const std::vector<std::string>& settings) {
  const auto found = shipped().find(name);
  if (found == shipped().end()) {
    std::string names;
    for (const auto& [shipped_name, unused] : shipped()) names = listed(names, shipped_name);
    throw BadOption("--vehicle " + name + ": no such vehicle; shipped are " + names);
  }
  Numbers numbers = found->second;
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    if (equals == std::string::npos) throw BadOption("--set " + setting + ": write key=number");
    const std::string key = setting.substr(0, equals);
    numbers[key] = checked(key, setting.substr(equals + 1));
  }
  check_flyable(name, numbers);

  VehicleSetup setup{name, firmware_vehicle(numbers), plant_of(numbers), {}};
  setup.params.thrust_reference = 4.0F * setup.vehicle.thrust_max;
  setup.params.drag = static_cast<float>(setup.plant.drag_N_s_m);
  for (const auto& [key, wanted] : numbers) {
    if (key.rfind("params.", 0) != 0) continue;
    const int index = find_param(key.substr(std::string("params.").size()).c_str());
    static_cast<void>(set_param(setup.params, index, static_cast<float>(wanted), false));
  }
  return setup;
}

}  // namespace halfroll::sitl
