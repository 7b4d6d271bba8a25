// Vehicles share nothing: batches and campaigns fly many of them in threads of one process.
#include <doctest/doctest.h>

#include <array>
#include <string>
#include <thread>
#include <vector>

#include "../link/command_frame.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/sensed.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/world.hpp"

namespace {

using namespace halfroll;

constexpr int kArmed = 1500, kSteps = 4000;

/// Rotor commands of every step, of a takeoff after the estimator has settled.
std::vector<std::array<float, 4>> flown(const std::string& vehicle, const std::string& scenario, std::uint64_t seed) {
  const sitl::VehicleSetup setup = sitl::make_vehicle(vehicle, {});
  const sim::Model model(setup.plant, sitl::make_scenario(scenario, {}));
  sim::World world = sim::start(model, seed);
  Autopilot autopilot(setup.vehicle, setup.params);
  const client::Bytes takeoff = client::command(MAV_CMD_NAV_TAKEOFF, 0.F, 5.F);
  const client::Bytes arm = client::command(MAV_CMD_COMPONENT_ARM_DISARM, 1.F);
  const std::array<link::Datagram, 2> orders = {
      {{{1, 0}, takeoff.data(), takeoff.size()}, {{1, 0}, arm.data(), arm.size()}}};
  std::vector<std::array<float, 4>> commands;
  for (int n = 0; n < kSteps; ++n) {
    Inputs in = sitl::sensed(world);
    in.link.wall_us = world.t_us;
    if (n == kArmed) {
      in.link.rx = orders.data();
      in.link.rx_count = orders.size();
    }
    const RotorCommands rotors = autopilot.step(in).rotors;
    commands.push_back(rotors.thrust);
    sim::step(model, world, rotors);
  }
  CHECK(world.body.p_WB.z() > 0.5);
  return commands;
}

}  // namespace

TEST_CASE("vehicles flown by several threads fly as each does alone") {
  struct Flight {
    std::string vehicle, scenario;
    std::vector<std::array<float, 4>> commands;
  };
  std::vector<Flight> flights;
  for (const char* vehicle : {"mit-vp", "mit-fp", "race-5in"}) {
    for (const char* scenario : {"ideal", "windy", "full"}) flights.push_back({vehicle, scenario, {}});
  }
  std::vector<std::thread> threads;
  for (Flight& flight : flights) {
    threads.emplace_back([&flight] { flight.commands = flown(flight.vehicle, flight.scenario, 7); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Flight& flight : flights) {
    CAPTURE(flight.vehicle);
    CAPTURE(flight.scenario);
    CHECK(flight.commands == flown(flight.vehicle, flight.scenario, 7));
  }
}
