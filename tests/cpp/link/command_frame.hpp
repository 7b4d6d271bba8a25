// A command as a ground control station sends it.
#pragma once
#include "client.hpp"

namespace client {

inline Bytes command(std::uint16_t number, float p1, float p7 = 0.F) {
  mavlink_command_long_t m = {};
  m.target_system = m.target_component = 1;
  m.command = number;
  m.param1 = p1;
  m.param7 = p7;
  return frame(m, mavlink_msg_command_long_encode_status);
}

}  // namespace client
