// The setpoints of OFFBOARD: whose, how old, and what their age means. Why: a link that stops must never be noticed
// late.
#pragma once
#include "core/params.hpp"
#include "core/types.hpp"

namespace halfroll {

/// A setpoint as it came by link, in W and B, with what is needed to judge it.
struct LinkSetpoint {
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();  // [rad/s]
  float thrust = 0.F;          // -1..1
  std::uint8_t type_mask = 0;
  std::uint32_t stamp_ms = 0;   // sender's time_boot_ms; vehicle time if it follows it
  std::uint32_t source = 0;     // who: differs for every (system, component, endpoint)
  bool ground_station = false;  // component 191
  float patience = 1.F;         // this source's clock runs so many times slower than vehicle time
};

/// What the age of the last good setpoint asks for.
enum class OffboardStage : std::uint8_t { kWaiting, kTracking, kNoRates, kRecovering, kLost, kNeverStarted };

class Offboard {
 public:
  void enter(std::uint64_t t_us);

  /// Use the setpoint whole, or say why it was dropped. `active`: in mode OFFBOARD (else it is only remembered).
  const char* accept(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params);

  OffboardStage stage(std::uint64_t t_us, bool armed, const Params& params) const;
  const Setpoint& setpoint() const { return setpoint_; }
  std::uint8_t type_mask() const { return type_mask_; }
  /// Of the source that is followed; of `otherwise` while none is yet.
  bool owned_by_ground_station(bool otherwise) const { return has_owner_ ? owner_is_ground_ : otherwise; }
  std::uint32_t dropped() const { return dropped_; }

  auto state() const {
    return std::tie(setpoint_.t_us, setpoint_.q_WD, setpoint_.w_WD_D, setpoint_.thrust, type_mask_, entered_us_,
                    last_good_us_, has_setpoint_, has_owner_, owner_, owner_is_ground_, owner_patience_, last_stamp_ms_,
                    dropped_);
  }

 private:
  const char* judge(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params) const;

  Setpoint setpoint_;
  std::uint8_t type_mask_ = 0;
  std::uint64_t entered_us_ = 0, last_good_us_ = 0;
  bool has_setpoint_ = false;
  bool has_owner_ = false;
  std::uint32_t owner_ = 0;
  bool owner_is_ground_ = false;
  float owner_patience_ = 1.F;
  std::uint32_t last_stamp_ms_ = 0;
  std::uint32_t dropped_ = 0;
};

}  // namespace halfroll
