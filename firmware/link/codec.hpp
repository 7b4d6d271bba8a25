// Bytes <-> messages. Why: the generated MAVLink headers, packed structs and CRCs end here.
#pragma once
#include <optional>

#include "link/frames.hpp"
#include "link/messages.hpp"
#include "link/vehicle_status.hpp"

namespace halfroll::link {

struct Received {
  Header header;
  Message message;
  std::uint32_t id = 0;
  std::uint8_t sequence = 0;
  bool is_signed = false;
  const std::uint8_t* frame = nullptr;  // as it came; valid while it is used
  std::size_t frame_size = 0;
};

/// Finds frames in the bytes of one endpoint: MAVLink 1 and 2, signed or not, any split. Bad ones are counted and
/// skipped; after a bad frame the search goes on at its second byte, so a damaged length costs no good frame.
class Parser {
 public:
  /// Calls use(const Received&) for each good frame.
  template <class Use>
  void parse(const Datagram& datagram, Use&& use) {
    for (std::size_t i = 0; i < datagram.size; ++i) {
      push(datagram.bytes[i]);
      if (size_ < look_at_) continue;
      while (const std::optional<Received> received = next(datagram.from)) use(*received);
    }
  }

  std::uint32_t bad_frames() const { return bad_frames_; }
  bool operator==(const Parser& o) const {
    return size_ == o.size_ && bad_frames_ == o.bad_frames_ && std::memcmp(bytes_.data(), o.bytes_.data(), size_) == 0;
  }

 private:
  void push(std::uint8_t byte);
  std::optional<Received> next(Endpoint from);
  void drop(std::size_t count);

  std::array<std::uint8_t, 280> bytes_ = {};
  std::size_t size_ = 0;
  std::size_t look_at_ = 1;  // so many bytes are needed to tell more
  std::size_t used_ = 0;     // bytes of the frame that is being used
  std::uint32_t bad_frames_ = 0;
};

/// Who sends, and with which number: a sequence is counted per link.
struct Envelope {
  std::uint8_t system = 1;
  std::uint8_t sequence = 0;
  std::uint8_t component = kAutopilotComponent;
};

/// One MAVLink 2 frame; `to` is left to the caller.
TxFrame encode(const CommandAck&, Envelope);
TxFrame encode(const StatusText&, Envelope);
TxFrame encode(const ParamValue&, Envelope);
TxFrame encode(const ParamRefusal&, Envelope);
TxFrame encode(const MissionCount&, Envelope);
TxFrame encode(const MissionItemMessage&, Envelope);
TxFrame encode(const MissionRequest&, Envelope);
TxFrame encode(const MissionAck&, Envelope);
TxFrame encode(const MissionItemReached&, Envelope);
TxFrame encode(const MessageInterval&, Envelope);
TxFrame encode(const Timesync&, Envelope);
TxFrame encode(const Ping&, Envelope);
TxFrame encode(const FileTransfer&, Envelope);

/// What the ground station sends to the vehicle of the same system (codec_ground.cpp).
TxFrame encode_from_ground(const SetAttitudeTarget&, Envelope);

/// Announces a signature and leaves 13 bytes for it (signing.hpp).
void make_room_for_signature(TxFrame& frame);

/// A message that shows the vehicle: which one, of what, and for AVAILABLE_MODES which mode (1..kWireModeCount),
/// for SYS_STATUS which link.
struct Telemetry {
  std::uint32_t id = 0;
  const VehicleStatus& status;
  int mode_index = 1;
  int link = 0;  // for SYS_STATUS
};
/// Size 0 if the id is not one of ours or there is nothing to show yet (no home).
TxFrame encode(const Telemetry&, Envelope);

}  // namespace halfroll::link
