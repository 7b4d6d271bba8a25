// A simulated vehicle and its links wired together. Why: when bytes and commands are exchanged is what makes a flight
// repeatable, so it stands in one place. No physics and no control here.
#pragma once
#include <csignal>
#include <cstdint>
#include <vector>

#include "boards/host/udp_links.hpp"
#include "sim/sitl/simulated_vehicle.hpp"

namespace halfroll::sitl {

class Simulation {
 public:
  /// `stop` becomes non-zero when the user wants to end. Throws host::PortInUse, std::runtime_error.
  Simulation(const Options& options, const VehicleSetup& setup, const Version& version,
             const volatile std::sig_atomic_t& stop);

  /// Fly until told to end: by a signal, a command, or --duration.
  void run();

  const SimulatedVehicle& vehicle() const { return vehicle_; }

 private:
  enum class Ground { kAnswered, kSilent, kEnding };
  enum class Say { kNow, kAtBarrier };

  void step(bool listening);
  Ground wait_for_ground();
  LinkInputs hear(std::size_t most, std::size_t most_bytes);
  void carry(const LinkOutputs& out, Say when);
  void release();
  void reboot();
  bool ending() const;

  Options options_;
  const volatile std::sig_atomic_t& stop_;
  host::UdpLinks links_;
  SimulatedVehicle vehicle_;
  std::vector<link::TxFrame> held_;  // until the barrier

  std::uint64_t wall_us_ = 0;  // as the firmware knows it
  bool shut_down_ = false, rebooting_ = false;
  bool ground_seen_ = false;  // 191 has answered once
  std::uint32_t ground_frames_ = 0;
  std::uint64_t ground_heard_us_ = 0;  // wall clock
};

}  // namespace halfroll::sitl
