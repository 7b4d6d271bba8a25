// Bytes on their way in and out. Why: the firmware knows links and endpoint numbers, never sockets or addresses.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace halfroll::link {

inline constexpr int kLinkCount = 3;            // 0: A, offboard; 1: B, ground control stations; 2: C, companion
inline constexpr std::uint8_t kEveryone = 255;  // all endpoints of a link
inline constexpr std::uint8_t kAllLinks = 255;

/// What one step reads of a link at most, so that a flood cannot starve the loop; service, when no time passes, reads
/// all.
inline constexpr std::size_t kStepDatagrams = 8;
inline constexpr std::size_t kStepBytes = 4096;

/// Where bytes came from or go to; slots are numbered by the shell (0 is the link's default peer).
struct Endpoint {
  std::uint8_t link = 0;
  std::uint8_t slot = 0;
  bool operator==(const Endpoint& o) const { return link == o.link && slot == o.slot; }
};

/// Bytes received; any split into datagrams is fine.
struct Datagram {
  Endpoint from;
  const std::uint8_t* bytes = nullptr;
  std::size_t size = 0;
};

/// One encoded MAVLink 2 frame to send.
struct TxFrame {
  Endpoint to;
  std::uint16_t size = 0;
  std::array<std::uint8_t, 280> bytes;  // those up to size are written
};

/// What is kept over a restart. The shell writes it (boards/two_slots.hpp) and tells the result.
enum class StorageSlot : std::uint8_t { kNone, kParams, kMission, kSigning };
inline constexpr std::size_t kStorageSlotCount = 4;
enum class StoredState : std::uint8_t {
  kNothing,           // nothing was ever stored
  kSound,             //
  kOtherCopyDamaged,  // the image is good, but the store's other copy is torn or corrupt: perhaps it was the newer one
  kLost               // no copy is good
};
struct StoredImage {
  StoredState state = StoredState::kNothing;
  const std::uint8_t* bytes = nullptr;
  std::size_t size = 0;
};
struct StorageRequest {
  StorageSlot slot = StorageSlot::kNone;
  const std::uint8_t* bytes = nullptr;  // valid until the next call into the autopilot
  std::size_t size = 0;
};
struct StorageResult {
  StorageSlot slot = StorageSlot::kNone;
  bool ok = false;
};

}  // namespace halfroll::link
