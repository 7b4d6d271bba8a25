#include "link/signing.hpp"

#include <algorithm>
#include <cstring>

#include "link/checksum.hpp"
#include "link/sha256.hpp"

namespace halfroll::link {
namespace {

constexpr std::uint64_t kUnixOf2015Us = 1420070400000000U;
constexpr std::uint64_t kMinute = 6000000;  // [10 us]
constexpr std::size_t kSignatureSize = 13, kHashSize = 6;
constexpr std::uint32_t kMagic = 0x31535248;  // "HRS1"

std::uint64_t stamp_of(const std::uint8_t* signature) {
  std::uint64_t stamp = 0;
  for (std::size_t i = 6; i > 0; --i) stamp = stamp << 8U | signature[i];
  return stamp;
}

/// First six bytes of the hash over key and frame, the hash's own place left out.
std::array<std::uint8_t, kHashSize> hash48(const SigningKey& key, const std::uint8_t* frame, std::size_t size) {
  Sha256 hash;
  hash.add(key.data(), key.size());
  hash.add(frame, size - kHashSize);
  const std::array<std::uint8_t, 32> whole = hash.digest();
  std::array<std::uint8_t, kHashSize> out{};
  std::copy_n(whole.begin(), kHashSize, out.begin());
  return out;
}

}  // namespace

Signing::Signing(const std::array<SigningPolicy, kLinkCount>& policies, const std::optional<SigningKey>& key,
                 std::uint64_t unix_us_at_wall_0, const StoredImage& stored)
    : policies_(policies), unix_us_at_wall_0_(unix_us_at_wall_0) {
  std::uint32_t magic = 0, checksum = 0;
  if (stored.size == image_.size()) {
    std::memcpy(&magic, stored.bytes, 4);
    std::memcpy(&checksum, stored.bytes + 44, 4);
    if (magic == kMagic && checksum == crc32(stored.bytes, 44)) {
      SigningKey kept{};
      std::memcpy(kept.data(), stored.bytes + 4, kept.size());
      std::memcpy(&now_, stored.bytes + 36, sizeof now_);
      if (std::any_of(kept.begin(), kept.end(), [](std::uint8_t byte) { return byte != 0; })) key_ = kept;
    }
  }
  set_aside_ = now_;
  if (!key || key == key_) return;
  key_ = key;
  dirty_ = true;
}

/// Our stamp follows the time of day where that is known and ahead.
void Signing::keep_time(std::uint64_t wall_us) {
  if (unix_us_at_wall_0_ == 0) return;
  const std::uint64_t unix_us = unix_us_at_wall_0_ + wall_us;
  if (unix_us > kUnixOf2015Us) now_ = std::max(now_, (unix_us - kUnixOf2015Us) / 10);
}

bool Signing::admits(const Received& received, std::uint64_t wall_us) {
  const SigningPolicy rule = policy(received.header.from.link);
  if (rule == SigningPolicy::kOff || !key_) return true;
  if (received.is_signed) return is_genuine(received, wall_us);
  return rule != SigningPolicy::kRequire || received.id == msg::kRadioStatus;
}

bool Signing::is_genuine(const Received& received, std::uint64_t wall_us) {
  const std::uint8_t* signature = received.frame + received.frame_size - kSignatureSize;
  const auto expected = hash48(*key_, received.frame, received.frame_size);
  if (std::memcmp(expected.data(), signature + kSignatureSize - kHashSize, kHashSize) != 0) return false;
  keep_time(wall_us);
  return is_new(received.header.sender, signature[0], stamp_of(signature));
}

/// Later than all from this stream before; a stream never heard may be a minute behind us.
bool Signing::is_new(const Address& sender, std::uint8_t link_id, std::uint64_t stamp) {
  const auto end = streams_.begin() + static_cast<std::ptrdiff_t>(stream_count_);
  const auto known =
      std::find_if(streams_.begin(), end, [&](const Stream& s) { return s.sender == sender && s.link_id == link_id; });
  if (known != end) {
    if (stamp <= known->last) return false;
    known->last = stamp;
  } else {
    if (stamp + kMinute < now_ || stream_count_ == streams_.size()) return false;
    streams_[stream_count_++] = {sender, link_id, stamp};
  }
  now_ = std::max(now_, stamp);
  return true;
}

void Signing::sign(TxFrame& frame, std::uint64_t wall_us) {
  if (!signs(frame.to.link)) return;
  keep_time(wall_us);
  ++now_;
  make_room_for_signature(frame);
  std::uint8_t* signature = frame.bytes.data() + frame.size - kSignatureSize;
  signature[0] = frame.to.link;
  for (std::size_t i = 0; i < 6; ++i)
    signature[1 + i] = static_cast<std::uint8_t>(now_ >> (8U * static_cast<unsigned>(i)));
  const auto hash = hash48(*key_, frame.bytes.data(), frame.size);
  std::copy(hash.begin(), hash.end(), signature + kSignatureSize - kHashSize);
}

void Signing::set_up(const SetupSigning& message) {
  const bool none = std::all_of(message.key.begin(), message.key.end(), [](std::uint8_t byte) { return byte == 0; });
  key_ = none ? std::nullopt : std::optional<SigningKey>(message.key);
  now_ = std::max(now_, message.initial_stamp);
  dirty_ = true;
}

StorageRequest Signing::take_storage() {
  if (!dirty_ && !(key_ && now_ > set_aside_)) return {};
  dirty_ = false;
  set_aside_ = now_ + kMinute;
  const SigningKey kept = key_.value_or(SigningKey{});
  std::memcpy(&image_[0], &kMagic, 4);
  std::memcpy(&image_[4], kept.data(), kept.size());
  std::memcpy(&image_[36], &set_aside_, sizeof set_aside_);
  const std::uint32_t checksum = crc32(image_.data(), 44);
  std::memcpy(&image_[44], &checksum, 4);
  return {StorageSlot::kSigning, image_.data(), image_.size()};
}

}  // namespace halfroll::link
