// Autopilot and world as one: every call that the firmware gets, in order, with what it hears. Why: a flight is these
// calls and nothing else, so they are made, hashed and logged in one place, whether live or replayed.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "link/sha256.hpp"
#include "sim/sitl/firmware.hpp"
#include "sim/sitl/flight_log.hpp"
#include "sim/sitl/options.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/sitl/world_orders.hpp"
#include "sim/world.hpp"

namespace halfroll::sitl {

/// What this process was built from.
struct Version {
  std::string release, commit;
};

class SimulatedVehicle {
 public:
  /// Powers it on. unix_us_at_wall_0: the time of day when wall_us was 0. Throws std::runtime_error where there can be
  /// no log.
  SimulatedVehicle(const Options& options, const VehicleSetup& setup, const Version& version,
                   std::unique_ptr<Firmware> firmware, std::uint64_t unix_us_at_wall_0);

  /// One millisecond. Here and in service, what is heard may be addressed to the world, which answers; what comes by a
  /// link that is cut never came.
  LinkOutputs step(const LinkInputs& heard);
  /// No time passes.
  LinkOutputs service(const LinkInputs& heard);
  void ask_time();
  /// The autopilot starts again from what is stored, and its clock with it; the vehicle stays where it is.
  void reboot(std::uint64_t unix_us_at_wall_0);
  /// The last words of a board, and the log's; false if that is not complete.
  bool finish();

  /// Of the world, since the call before.
  const std::vector<link::TxFrame>& answers() const { return answers_; }
  /// Whether nothing passes a link.
  bool is_cut(std::uint8_t link) const { return orders_.is_cut(link, t_us()); }
  const hil::Shown& shown() const { return firmware_->shown(); }
  bool has_links_of_its_own() const { return firmware_->has_links_of_its_own(); }
  std::uint64_t t_us() const { return steps_ * kStepUs; }  // flown; a reboot does not set it back
  double flown_s() const { return 1e-6 * static_cast<double>(t_us()); }
  std::string commands_sha256() const { return commands_.hex().data(); }
  /// What the board has measured, one line of JSON; empty without a board.
  const std::string& board_report() const { return board_report_; }

 private:
  LinkInputs obey(const LinkInputs& heard);
  void write_down_start();
  void write_down(const LinkOutputs& out);
  void tell_of_crash();

  boards::Start start_;
  std::unique_ptr<Firmware> firmware_;
  sim::Model model_;
  sim::World world_;
  WorldOrders orders_;
  std::vector<link::Datagram> passed_;  // to the firmware
  std::vector<link::TxFrame> answers_;
  std::optional<FlightLog> log_;

  link::Sha256 commands_;
  std::uint64_t steps_ = 0;
  std::string board_report_;
  bool crash_told_ = false;
};

}  // namespace halfroll::sitl
