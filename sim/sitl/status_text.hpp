// STATUSTEXT on its way out, for the log. Why: what the autopilot said belongs beside what it did.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "link/datagram.hpp"

namespace halfroll::sitl {

struct SaidText {
  std::uint8_t severity = 0;  // as in syslog
  std::string line;
};

/// The text of a MAVLink 2 frame of message 253; nothing for any other. Zeros at its end are cut off on the wire.
inline std::optional<SaidText> said(const link::TxFrame& frame) {
  constexpr std::size_t kHeader = 10, kTextAt = kHeader + 1, kLongest = 50;
  const auto& b = frame.bytes;
  if (b[0] != 0xFD || b[7] != 253 || b[8] != 0 || b[9] != 0 || b[1] == 0) return std::nullopt;
  SaidText text{b[kHeader], {}};
  for (std::size_t i = kTextAt; i < kHeader + b[1] && i < kTextAt + kLongest && b[i] != 0; ++i) {
    text.line += static_cast<char>(b[i]);
  }
  return text;
}

}  // namespace halfroll::sitl
