// The autopilot: sensors and bytes in, rotor commands and bytes out, one millisecond a step. No clock, no socket, no file.
#pragma once
#include <memory>
#include <optional>

#include "core/params.hpp"
#include "core/types.hpp"
#include "core/vehicle.hpp"
#include "link/datagram.hpp"

namespace halfroll {

struct Battery {
  float voltage = 16.8F;          // [V]
  float state_of_charge = 1.F;    // 0..1
};

/// What the links brought since the last call.
struct LinkInputs {
  const link::Datagram* rx = nullptr;
  std::size_t rx_count = 0;
  std::uint64_t wall_us = 0;        // the shell's monotonic clock: paces bulk answers and heartbeats while time stands
  link::StorageResult stored;       // outcome of the last StorageRequest
};

/// What the links take away; valid until the next call.
struct LinkOutputs {
  const link::TxFrame* tx = nullptr;
  std::size_t tx_count = 0;
  link::StorageRequest store;
  bool shut_down = false;           // the vehicle was told to switch off
  bool reboot = false;
};

struct Inputs {
  Imu imu;
  std::optional<PoseFix> pose;
  Battery battery;
  LinkInputs link;
};

struct Outputs {
  RotorCommands rotors;
  LinkOutputs link;
};

/// Everything decided before the first step.
struct Boot {
  double origin_lat_deg = 47.397742, origin_lon_deg = 8.545594;  // local origin (WGS84)
  double origin_alt_m = 488.0;                                   // above mean sea level
  bool px4_identity = false;
  const std::uint8_t* stored_params = nullptr;
  std::size_t stored_params_size = 0;
  const std::uint8_t* stored_mission = nullptr;
  std::size_t stored_mission_size = 0;
};

enum class Mode : std::uint8_t;  // core/modes.hpp

/// One vehicle's firmware. A value: copying it copies the whole autopilot; equal states fly equal flights.
class Autopilot {
 public:
  Autopilot(const Vehicle& vehicle, const Params& params, const Boot& boot = {});
  Autopilot(const Autopilot& other);
  Autopilot& operator=(const Autopilot& other);
  ~Autopilot();

  /// Advance 1 ms.
  Outputs step(const Inputs& in);
  /// Answer the links while no time passes (the simulator stands, or between steps).
  LinkOutputs service(const LinkInputs& in);

  /// Lockstep: queue TIMESYNC (tc1 = 0, ts1 = now) to link A's default peer; answered once component 191 echoes it.
  void ask_time();
  bool time_answered() const;
  /// Valid frames of component 191 so far (it is alive while this grows).
  std::uint32_t ground_frames() const;

  std::uint64_t t_us() const;
  bool armed() const;
  Mode mode() const;
  const Estimate& estimate() const;
  const Reference& reference() const;
  const Params& params() const;
  bool same_state(const Autopilot& other) const;
};

}  // namespace halfroll
