// Room for a signature: the flag that announces it is covered by the frame's own checksum, so that is made again.
#include "link/codec_mavlink.hpp"

namespace halfroll::link {

void make_room_for_signature(TxFrame& frame) {
  constexpr std::size_t kHeader = MAVLINK_NUM_HEADER_BYTES, kChecksum = MAVLINK_NUM_CHECKSUM_BYTES;
  std::uint8_t* bytes = frame.bytes.data();
  bytes[2] |= MAVLINK_IFLAG_SIGNED;
  const std::size_t payload = bytes[1];
  const std::uint32_t id = bytes[7] | std::uint32_t{bytes[8]} << 8U | std::uint32_t{bytes[9]} << 16U;
  std::uint16_t crc = crc_calculate(bytes + 1, static_cast<std::uint16_t>(kHeader - 1 + payload));
  crc_accumulate(mavlink_get_msg_entry(id)->crc_extra, &crc);
  bytes[kHeader + payload] = static_cast<std::uint8_t>(crc);
  bytes[kHeader + payload + 1] = static_cast<std::uint8_t>(crc >> 8U);
  frame.size = static_cast<std::uint16_t>(kHeader + payload + kChecksum + MAVLINK_SIGNATURE_BLOCK_LEN);
}

}  // namespace halfroll::link
