// MAVLink 2 signing, per link. Why: whoever can reach a link can otherwise fly the vehicle.
//
// A signed frame ends with 13 bytes: link id, time stamp (48 bits, 10 us since 2015), and the first 48 bits of
// SHA-256(key, frame up to and with the time stamp).
#pragma once
#include <array>
#include <optional>
#include <tuple>

#include "link/codec.hpp"

namespace halfroll::link {

using SigningKey = std::array<std::uint8_t, 32>;

enum class SigningPolicy : std::uint8_t {
  kOff,      // nothing is signed, signatures are not looked at
  kRequire,  // ours are signed; unsigned, wrongly signed and replayed frames are dropped, except RADIO_STATUS
  kAccept,   // ours are signed; unsigned frames are taken, too
  kTrusted   // as kAccept, and SETUP_SIGNING is obeyed while disarmed
};

class Signing {
 public:
  Signing() = default;
  /// `unix_us_at_wall_0`: the time of day when wall_us was 0; 0: unknown. The stored image may hold a key and always
  /// holds a time stamp that was never used; a given key goes before a stored one. An image that is not ours is as
  /// none.
  Signing(const std::array<SigningPolicy, kLinkCount>& policies, const std::optional<SigningKey>& key,
          std::uint64_t unix_us_at_wall_0, const StoredImage& stored);

  /// Whether the frame may be used.
  bool admits(const Received& received, std::uint64_t wall_us);
  /// Signs it if its link does.
  void sign(TxFrame& frame, std::uint64_t wall_us);
  bool signs(int link) const { return key_ && policy(link) != SigningPolicy::kOff; }

  /// SETUP_SIGNING on a trusted link; a key of zeros takes the key away.
  bool may_be_set_up(int link) const { return policy(link) == SigningPolicy::kTrusted; }
  void set_up(const SetupSigning& message);

  /// A key was set, or time stamps come near the last one that was set aside: an image to store. Valid until the next
  /// call.
  StorageRequest take_storage();
  void stored(bool ok) { dirty_ = dirty_ || !ok; }

 private:
  /// Who counts time stamps of its own.
  struct Stream {
    Address sender;
    std::uint8_t link_id = 0;
    std::uint64_t last = 0;
  };

  SigningPolicy policy(int link) const { return policies_[static_cast<std::size_t>(link)]; }
  void keep_time(std::uint64_t wall_us);
  bool is_genuine(const Received& received, std::uint64_t wall_us);
  bool is_new(const Address& sender, std::uint8_t link_id, std::uint64_t stamp);

  std::array<SigningPolicy, kLinkCount> policies_ = {};
  std::optional<SigningKey> key_;
  std::uint64_t unix_us_at_wall_0_ = 0;
  std::uint64_t now_ = 0;        // [10 us], of the last frame signed or admitted, never back
  std::uint64_t set_aside_ = 0;  // [10 us], stored: after a restart stamps begin here
  std::array<Stream, 16> streams_ = {};
  std::size_t stream_count_ = 0;
  bool dirty_ = false;
  std::array<std::uint8_t, 48> image_ = {};
};

}  // namespace halfroll::link
