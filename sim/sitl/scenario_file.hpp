// From the numbers of a scenario to the world's settings. Why: scenarios/*.toml reach C++ as one generated table; a
// scenario of the user's own comes as `--scenario-set key=number`, by the same keys.
#pragma once
#include <string>
#include <vector>

#include "sim/scenario.hpp"

namespace halfroll::sitl {

/// A shipped scenario, its numbers replaced by `settings`: "wind.mean_m_s.0=3", "fault.0.kind=weak-rotor". Throws
/// BadOption: unknown scenario or key, no number, out of range, a fault of no rotor.
sim::Scenario make_scenario(const std::string& name, const std::vector<std::string>& settings = {});

/// Names of the shipped ones, "ideal, nominal, ...".
std::string shipped_scenarios();

}  // namespace halfroll::sitl
