// The generated MAVLink headers, for codec*.cpp only. Why: their macros and packed structs must not spread.
#pragma once
#include <development/mavlink.h>

#include "link/codec.hpp"

namespace halfroll::link {

/// Frame of a generated struct; `encode_status` is its generated function, which keeps no global state.
template <class Packed>
TxFrame to_frame(const Packed& packed, Envelope envelope,
                 std::uint16_t (*encode_status)(std::uint8_t, std::uint8_t, mavlink_status_t*, mavlink_message_t*,
                                                const Packed*)) {
  mavlink_status_t status = {};  // flags 0: MAVLink 2
  status.current_tx_seq = envelope.sequence;
  mavlink_message_t message;  // written as far as it is read
  encode_status(envelope.system, envelope.component, &status, &message, &packed);
  TxFrame frame;
  frame.size = mavlink_msg_to_send_buffer(frame.bytes.data(), &message);
  return frame;
}

}  // namespace halfroll::link
