// From the numbers of a vehicle to what flies. Why: vehicles/*.toml reach C++ as one generated table; firmware and
// world are both built from it, so they can differ only where somebody says so.
#pragma once
#include <string>
#include <vector>

#include "core/params.hpp"
#include "core/vehicle.hpp"
#include "sim/plant.hpp"

namespace halfroll::sitl {

struct VehicleSetup {
  std::string name;
  Vehicle vehicle;   // for the firmware
  sim::Plant plant;  // for the world
  Params params;     // the firmware's defaults, then the vehicle's, then the settings
};

/// A shipped vehicle, its numbers replaced by `settings`: "rotor.thrust_max_N=2.5", "params.ATT_WN=12",
/// "rotor.kind=fixed-pitch". Throws BadOption: unknown vehicle or key, no number, out of range, cannot hover.
VehicleSetup make_vehicle(const std::string& name, const std::vector<std::string>& settings);

}  // namespace halfroll::sitl
