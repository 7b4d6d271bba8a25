// Sending in the place of a ground station. Why: simulated flights are streamed to through the same bytes; an image for
// a board never asks for this file.
#include "link/codec_mavlink.hpp"
#include "link/wire_ids.hpp"

namespace halfroll::link {

TxFrame encode_from_ground(const SetAttitudeTarget& in, Envelope envelope) {
  mavlink_set_attitude_target_t m = {};
  const Quat q = to_wire(in.q_WD);
  const Vec3 rate = to_wire(in.w_WD_D);
  m.time_boot_ms = in.time_boot_ms;
  m.target_system = envelope.system;
  m.target_component = kAutopilotComponent;
  m.type_mask = in.type_mask;
  m.q[0] = q.w, m.q[1] = q.x, m.q[2] = q.y, m.q[3] = q.z;
  m.body_roll_rate = rate.x(), m.body_pitch_rate = rate.y(), m.body_yaw_rate = rate.z();
  m.thrust = in.thrust;
  return to_frame(m, envelope, mavlink_msg_set_attitude_target_encode_status);
}

}  // namespace halfroll::link
