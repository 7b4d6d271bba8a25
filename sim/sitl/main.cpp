// halfroll-sitl: the autopilot in a simulated vehicle, as a process. Command line in, exit code out.
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "boards/host/byte_channel.hpp"
#include "sim/sitl/bad_option.hpp"
#include "sim/sitl/simulation.hpp"

namespace {

using halfroll::sitl::Options;

constexpr int kBadOption = 2, kLost = 3;
constexpr int kLastSystemId = 250;

volatile std::sig_atomic_t stop = 0;

void end_on_signals() {
  struct sigaction action{};
  action.sa_handler = [](int) { stop = 1; };  // no SA_RESTART: a sleep ends, too
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int complain(int code, const std::string& sentence) {
  std::fprintf(stderr, "halfroll-sitl: %s\n", sentence.c_str());
  return code;
}

halfroll::sitl::VehicleSetup setup_from(const Options& options) {
  auto setup = halfroll::sitl::make_vehicle(options.vehicle, options.settings);
  const int system_id = static_cast<int>(setup.params.system_id) + options.instance;
  if (system_id > kLastSystemId) {
    throw halfroll::sitl::BadOption("--instance " + std::to_string(options.instance) + " makes MAVLink system id " +
                                    std::to_string(system_id) + ", the last one is " + std::to_string(kLastSystemId));
  }
  setup.params.system_id = static_cast<float>(system_id);
  if (!options.scenario.effects.drag) setup.params.drag = 0.0F;  // the firmware knows the air it flies in
  setup.params.simulation_speed = options.lockstep ? 1.0F : static_cast<float>(options.speed);
  return setup;
}

int fly(const Options& options) {
  halfroll::sitl::Simulation simulation(options, setup_from(options), HALFROLL_VERSION, stop);
  if (options.bind.rfind("127.", 0) != 0) {
    complain(0, "warning: listening on " + options.bind +
                    ", anybody who reaches it can fly this vehicle unless --signing require keeps him out");
  }
  std::printf(
      "halfroll-sitl: ready, offboard udp %d -> %d, gcs udp %d -> %d, companion udp %d -> %d, vehicle %s, scenario %s, "
      "seed %llu\n",
      options.port_offboard, options.peer_offboard, options.port_gcs, options.peer_gcs, options.port_companion,
      options.peer_companion, options.vehicle.c_str(), options.scenario_called.c_str(),
      static_cast<unsigned long long>(options.seed));
  std::fflush(stdout);
  simulation.run();
  std::printf("halfroll-sitl: flew %.3f s of vehicle time, commands_sha256 %s\n", simulation.flown_s(),
              simulation.commands_sha256().c_str());
  if (!simulation.board_report().empty()) std::printf("halfroll-sitl: board %s\n", simulation.board_report().c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  end_on_signals();
  try {
    const Options options = halfroll::sitl::parse_options(std::vector<std::string>(argv + 1, argv + argc));
    if (options.help) return std::fputs(halfroll::sitl::help_text().c_str(), stdout) < 0;
    if (options.version) return std::puts("halfroll-sitl " HALFROLL_VERSION) < 0;
    return fly(options);
  } catch (const halfroll::host::PortInUse& taken) {
    return complain(kLost, std::string(taken.what()) +
                               ", perhaps by another halfroll-sitl: start this one with --instance 1, or give "
                               "another --port-offboard, --port-gcs or --port-companion");
  } catch (const halfroll::host::BoardLost& lost) {
    return complain(kLost, lost.what());
  } catch (const std::exception& wrong) {
    return complain(kBadOption, wrong.what());
  }
}
