// Position targets in their many frames, read into W. Why: frames end in link/; the follower knows one.
#pragma once
#include "core/offboard.hpp"
#include "link/frames.hpp"
#include "link/messages.hpp"

namespace halfroll::link {

/// What the frames are measured from.
struct PositionDatum {
  Origin origin;
  float home_z = 0.F;   // W [m]
  float heading = 0.F;  // of the vehicle, W [rad]
};

/// In W; who sent it is left to the caller. Frames: LOCAL_NED (from the origin), BODY_NED (velocity and acceleration
/// along the vehicle's heading, no position), GLOBAL(_INT) and GLOBAL_RELATIVE_ALT(_INT). Others: frame_known = false.
LinkPositionSetpoint read_position_target(const PositionTarget& target, const PositionDatum& datum);

}  // namespace halfroll::link
