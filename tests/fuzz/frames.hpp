// MAVLink frames for fuzzers. Why: a random byte almost never passes a checksum, so frames are changed inside and
// sealed again, and what is fuzzed are the handlers, not the CRC.
#pragma once
#include <development/mavlink.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace halfroll::fuzz {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kHeader = 10;

inline std::uint32_t message_id(const Bytes& frame) {
  return frame[7] | std::uint32_t{frame[8]} << 8U | std::uint32_t{frame[9]} << 16U;
}

/// Length and checksum made right; frames of unknown messages stay as they are.
inline void seal(Bytes& frame) {
  const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(message_id(frame));
  if (entry == nullptr) return;
  const std::size_t payload = std::clamp<std::size_t>(frame.size() - std::min(frame.size(), kHeader + 2), 1, 255);
  frame.resize(kHeader + payload + 2);
  frame[0] = MAVLINK_STX;
  frame[1] = static_cast<std::uint8_t>(payload);
  frame[2] = 0;
  std::uint16_t crc = crc_calculate(frame.data() + 1, static_cast<std::uint16_t>(kHeader - 1 + payload));
  crc_accumulate(entry->crc_extra, &crc);
  frame[kHeader + payload] = static_cast<std::uint8_t>(crc & 0xFFU);
  frame[kHeader + payload + 1] = static_cast<std::uint8_t>(crc >> 8U);
}

/// An unsigned frame of our dialect from a payload.
inline Bytes frame_of(std::uint32_t id, const Bytes& payload) {
  Bytes frame(kHeader + std::max<std::size_t>(payload.size(), 1) + 2);
  frame[5] = 255;
  frame[6] = 190;
  for (std::size_t i = 0; i < 3; ++i) frame[7 + i] = static_cast<std::uint8_t>(id >> (8 * i));
  std::copy(payload.begin(), payload.end(), frame.begin() + kHeader);
  seal(frame);
  return frame;
}

/// A message as a client of this system number says it.
template <class Packed>
Bytes frame(const Packed& packed,
            std::uint16_t (*encode)(std::uint8_t, std::uint8_t, mavlink_status_t*, mavlink_message_t*, const Packed*),
            std::uint8_t system = 255) {
  mavlink_status_t status = {};
  mavlink_message_t message = {};
  encode(system, 190, &status, &message, &packed);
  Bytes bytes(MAVLINK_MAX_PACKET_LEN);
  bytes.resize(mavlink_msg_to_send_buffer(bytes.data(), &message));
  return bytes;
}

/// A message's fields, all zero but for its target.
template <class Packed>
Packed to_autopilot() {
  Packed m = {};
  m.target_system = m.target_component = 1;
  return m;
}

inline Bytes command(std::uint16_t number, float p1, float p2 = 0.F, float p7 = 0.F) {
  auto m = to_autopilot<mavlink_command_long_t>();
  m.command = number;
  m.param1 = p1;
  m.param2 = p2;
  m.param7 = p7;
  return frame(m, mavlink_msg_command_long_encode_status);
}

/// A mission item of a client, around the origin.
inline Bytes waypoint(std::uint16_t seq, std::int32_t north_degE7, std::int32_t east_degE7, float height) {
  auto m = to_autopilot<mavlink_mission_item_int_t>();
  m.seq = seq;
  m.command = MAV_CMD_NAV_WAYPOINT;
  m.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
  m.autocontinue = 1;
  m.x = 473977420 + north_degE7;
  m.y = 85455940 + east_degE7;
  m.z = height;
  return frame(m, mavlink_msg_mission_item_int_encode_status);
}

/// Bytes that mean something in turn; zeros after the last.
class Reader {
 public:
  Reader(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}
  bool empty() const { return at_ == end_; }
  std::uint8_t byte() { return empty() ? std::uint8_t{0} : *at_++; }

 private:
  const std::uint8_t *at_, *end_;
};

/// A stream cut where MAVLink 2 frames seem to begin; what is between them makes pieces too.
inline std::vector<Bytes> pieces(const std::uint8_t* bytes, std::size_t size) {
  std::vector<Bytes> out;
  for (std::size_t i = 0; i < size;) {
    std::size_t end = i + 1;
    if (bytes[i] == MAVLINK_STX && i + kHeader + 2 < size) {
      end = std::min(size, i + kHeader + 2 + bytes[i + 1]);
    } else {
      while (end < size && bytes[end] != MAVLINK_STX) ++end;
    }
    out.emplace_back(bytes + i, bytes + end);
    i = end;
  }
  return out;
}

inline bool looks_like_a_frame(const Bytes& piece) { return piece.size() > kHeader + 2 && piece[0] == MAVLINK_STX; }

}  // namespace halfroll::fuzz
