// MAVLink 2 signatures for fuzzers, by the generated code's own SHA-256. Why: a frame without one never reaches what
// stands behind a link that requires them.
#pragma once
#include <array>

#include "frames.hpp"

namespace halfroll::fuzz {

inline constexpr std::array<std::uint8_t, 32> kKey = {'h', 'a', 'l', 'f', 'r', 'o', 'l', 'l'};

/// What is wrong with a signature, if anything.
enum class Signature : std::uint8_t { kNone, kGood, kOfAnotherKey, kMissing };

/// A whole frame signed as from this stream at this time [10 us since 2015].
inline Bytes signed_as(Bytes frame, Signature how, std::uint8_t link_id, std::uint64_t stamp) {
  const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(message_id(frame));
  if (entry == nullptr || frame.size() != kHeader + frame[1] + 2 || how == Signature::kNone) return frame;
  frame[2] = MAVLINK_IFLAG_SIGNED;
  std::uint16_t crc = crc_calculate(frame.data() + 1, static_cast<std::uint16_t>(kHeader - 1 + frame[1]));
  crc_accumulate(entry->crc_extra, &crc);
  frame[frame.size() - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(crc >> 8U);
  if (how == Signature::kMissing) return frame;
  frame.push_back(link_id);
  for (int i = 0; i < 6; ++i) frame.push_back(static_cast<std::uint8_t>(stamp >> (8 * i)));
  std::array<std::uint8_t, 32> key = kKey;
  if (how == Signature::kOfAnotherKey) key[31] ^= 1U;
  mavlink_sha256_ctx hash;
  std::array<std::uint8_t, 6> head = {};
  mavlink_sha256_init(&hash);
  mavlink_sha256_update(&hash, key.data(), static_cast<std::uint32_t>(key.size()));
  mavlink_sha256_update(&hash, frame.data(), static_cast<std::uint32_t>(frame.size()));
  mavlink_sha256_final_48(&hash, head.data());
  frame.insert(frame.end(), head.begin(), head.end());
  return frame;
}

}  // namespace halfroll::fuzz
