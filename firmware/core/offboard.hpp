// The setpoints of OFFBOARD: whose, how old, and what their age means. Why: a link that stops must never be noticed
// late.
#pragma once
#include "core/params.hpp"
#include "core/position_setpoint.hpp"
#include "core/types.hpp"

namespace halfroll {

/// Who sent a setpoint, and when by the sender's account.
struct SetpointOrigin {
  std::uint32_t stamp_ms = 0;   // sender's time_boot_ms; vehicle time if it follows it
  std::uint32_t source = 0;     // who: differs for every (system, component, endpoint)
  bool ground_station = false;  // component 191
  float patience = 1.F;         // this source's clock runs so many times slower than vehicle time
};

/// SET_ATTITUDE_TARGET as it came by link, in W and B.
struct LinkSetpoint {
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();  // [rad/s]
  float thrust = 0.F;          // -1..1
  std::uint8_t type_mask = 0;
  SetpointOrigin origin;
};

/// SET_POSITION_TARGET_* as it came by link; in `setpoint` everything is filled in, used or not, and may be NaN.
struct LinkPositionSetpoint {
  PositionSetpoint setpoint;
  std::uint16_t type_mask = 0;
  bool frame_known = true;
  SetpointOrigin origin;
};

/// What the age of the last good setpoint asks for.
enum class OffboardStage : std::uint8_t { kWaiting, kTracking, kNoRates, kRecovering, kLost, kNeverStarted };

class Offboard {
 public:
  void enter(std::uint64_t t_us);

  /// Use the setpoint whole, or say why it was dropped. `active`: in mode OFFBOARD (else it is only remembered).
  const char* accept(const LinkSetpoint& in, std::uint64_t t_us, bool active, const Params& params);
  const char* accept(const LinkPositionSetpoint& in, std::uint64_t t_us, bool active, const Params& params);

  OffboardStage stage(std::uint64_t t_us, bool armed, const Params& params) const;
  /// The last good one asks for a place or a speed, not for an attitude.
  bool is_position() const { return is_position_; }
  const Setpoint& setpoint() const { return setpoint_; }
  /// Brought to t_us: moved on with its velocity and acceleration, which streams of 20 Hz rely on.
  PositionSetpoint position_setpoint(std::uint64_t t_us) const;
  std::uint8_t type_mask() const { return type_mask_; }
  /// Of the source that is followed; of `otherwise` while none is yet.
  bool owned_by_ground_station(bool otherwise) const { return has_owner_ ? owner_is_ground_ : otherwise; }
  std::uint32_t dropped() const { return dropped_; }

  auto state() const {
    return std::tuple_cat(std::tie(setpoint_.t_us, setpoint_.q_WD, setpoint_.w_WD_D, setpoint_.thrust, type_mask_,
                                   entered_us_, last_good_us_, has_setpoint_, is_position_, has_owner_, owner_,
                                   owner_is_ground_, owner_patience_, last_stamp_ms_, dropped_),
                          position_.state());
  }

 private:
  const char* judge(const SetpointOrigin& from, std::uint64_t t_us, bool active, const Params& params) const;
  void used(const SetpointOrigin& from, std::uint64_t t_us);

  Setpoint setpoint_;
  PositionSetpoint position_;
  bool is_position_ = false;
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
