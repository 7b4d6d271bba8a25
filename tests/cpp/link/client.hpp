// The other end of the link, for tests: frames made and read by the generated MAVLink code alone.
#pragma once
#include <development/mavlink.h>
#include <doctest/doctest.h>

#include <vector>

#include "link/codec.hpp"
#include "link/outbox.hpp"

namespace client {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kSystem = 255, kComponent = 190;
inline halfroll::link::Header header(std::uint8_t link = 0, std::uint8_t slot = 0,
                                     std::uint8_t component = kComponent) {
  return {{kSystem, component}, {1, 1}, {link, slot}};
}

template <class Packed>
Bytes frame(const Packed& packed,
            std::uint16_t (*encode)(std::uint8_t, std::uint8_t, mavlink_status_t*, mavlink_message_t*, const Packed*),
            bool version1 = false) {
  mavlink_status_t status = {};
  if (version1) status.flags = MAVLINK_STATUS_FLAG_OUT_MAVLINK1;
  mavlink_message_t message = {};
  encode(kSystem, kComponent, &status, &message, &packed);
  Bytes bytes(MAVLINK_MAX_PACKET_LEN);
  bytes.resize(mavlink_msg_to_send_buffer(bytes.data(), &message));
  return bytes;
}

/// A received frame as the generated code reads it.
inline mavlink_message_t read(const halfroll::link::TxFrame& frame) {
  mavlink_message_t buffer = {}, message = {};
  mavlink_status_t status = {}, shown = {};
  int good = 0;
  for (std::size_t i = 0; i < frame.size; ++i) {
    good = mavlink_frame_char_buffer(&buffer, &status, frame.bytes[i], &message, &shown);
  }
  CHECK(good == MAVLINK_FRAMING_OK);
  return message;
}

template <class Packed>
Packed read(const halfroll::link::TxFrame& frame, void (*decode)(const mavlink_message_t*, Packed*)) {
  const mavlink_message_t message = read(frame);
  Packed packed;
  decode(&message, &packed);
  return packed;
}

inline std::vector<halfroll::link::TxFrame> frames(const halfroll::link::Outbox& outbox) {
  return {outbox.frames(), outbox.frames() + outbox.size()};
}

/// Frames with this message id.
inline std::vector<halfroll::link::TxFrame> frames(const halfroll::link::Outbox& outbox, std::uint32_t id) {
  std::vector<halfroll::link::TxFrame> out;
  for (const auto& frame : frames(outbox)) {
    if (read(frame).msgid == id) out.push_back(frame);
  }
  return out;
}

inline std::vector<halfroll::link::Received> parse(halfroll::link::Parser& parser, const Bytes& bytes,
                                                   halfroll::link::Endpoint from = {0, 1}) {
  std::vector<halfroll::link::Received> out;
  parser.parse({from, bytes.data(), bytes.size()}, [&](const halfroll::link::Received& r) { out.push_back(r); });
  return out;
}

}  // namespace client
