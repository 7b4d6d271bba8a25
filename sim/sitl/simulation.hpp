// Autopilot, world and links wired together. Why: the order in which bytes, sensors and commands are exchanged is what
// makes a flight repeatable, so it stands in one place. No physics and no control here.
#pragma once
#include <csignal>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "autopilot.hpp"
#include "boards/host/udp_links.hpp"
#include "link/sha256.hpp"
#include "sim/sitl/firmware.hpp"
#include "sim/sitl/flight_log.hpp"
#include "sim/sitl/options.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/sitl/world_orders.hpp"
#include "sim/world.hpp"

namespace halfroll::sitl {

class Simulation {
 public:
  /// `stop` becomes non-zero when the user wants to end. Throws host::PortInUse, std::runtime_error.
  Simulation(const Options& options, const VehicleSetup& setup, const std::string& version,
             const volatile std::sig_atomic_t& stop);

  /// Fly until told to end: by a signal, a command, or --duration.
  void run();

  double flown_s() const { return 1e-6 * static_cast<double>(steps_ * kStepUs); }
  std::string commands_sha256() const { return commands_.hex().data(); }
  /// What the board has measured, one line of JSON; empty without a board.
  const std::string& board_report() const { return board_report_; }

 private:
  enum class Ground { kAnswered, kSilent, kEnding };
  enum class Say { kNow, kAtBarrier };

  void step(bool listening);
  Ground wait_for_ground();
  LinkInputs hear(std::size_t most, std::size_t most_bytes);
  void obey();
  void carry(const LinkOutputs& out, Say when);
  void release();
  void reboot();
  void tell_of_crash();
  bool ending() const;

  Options options_;
  VehicleSetup setup_;
  const volatile std::sig_atomic_t& stop_;
  host::UdpLinks links_;
  std::vector<link::TxFrame> held_;  // until the barrier
  std::vector<link::Datagram> heard_;
  std::optional<FlightLog> log_;
  std::unique_ptr<Firmware> firmware_;
  WorldOrders orders_;
  sim::Model model_;
  sim::World world_;

  link::Sha256 commands_;
  std::uint64_t steps_ = 0;
  bool shut_down_ = false, rebooting_ = false;
  std::string board_report_;
  bool crash_told_ = false;
  bool ground_seen_ = false;  // 191 has answered once
  std::uint32_t ground_frames_ = 0;
  std::uint64_t ground_heard_us_ = 0;  // wall clock
};

}  // namespace halfroll::sitl
