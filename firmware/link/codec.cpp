// Receiving: bytes -> frames -> messages.
#include "link/codec.hpp"

#include <algorithm>
#include <cmath>

#include "link/codec_mavlink.hpp"

namespace halfroll::link {
namespace {

constexpr std::size_t kSizeUnknown = 0;  // more bytes needed to tell
constexpr std::size_t kNotAFrame = 1;
constexpr float kMostAngle = 100.F;  // [rad], of one that is meant

/// Bytes that the frame starting here has, by its first bytes.
std::size_t frame_size(const std::uint8_t* bytes, std::size_t size) {
  if (bytes[0] == MAVLINK_STX_MAVLINK1) return size < 2 ? kSizeUnknown : std::size_t{bytes[1]} + 8;
  if (bytes[0] != MAVLINK_STX) return kNotAFrame;
  if (size < 3) return kSizeUnknown;
  if ((bytes[2] & ~MAVLINK_IFLAG_SIGNED) != 0) return kNotAFrame;
  return std::size_t{bytes[1]} + 12 + (bytes[2] != 0 ? MAVLINK_SIGNATURE_BLOCK_LEN : 0);
}

/// The whole frame as the generated code reads messages; false: unknown id, wrong checksum, or too short. The generated
/// parser would come to the same by a state machine over each byte, at five times the cost.
bool read_frame(const std::uint8_t* bytes, mavlink_message_t& message) {
  const bool second = bytes[0] == MAVLINK_STX;
  const std::size_t header = second ? MAVLINK_NUM_HEADER_BYTES : MAVLINK_CORE_HEADER_MAVLINK1_LEN + 1;
  const std::uint8_t* from = bytes + (second ? 4 : 2);  // sequence, system, component, id
  message.magic = bytes[0];
  message.len = bytes[1];
  message.incompat_flags = second ? bytes[2] : std::uint8_t{0};
  message.seq = from[0];
  message.sysid = from[1];
  message.compid = from[2];
  message.msgid = second ? from[3] | std::uint32_t{from[4]} << 8U | std::uint32_t{from[5]} << 16U : from[3];
  const mavlink_msg_entry_t* entry = mavlink_get_msg_entry(message.msgid);
  if (entry == nullptr || message.len == 0) return false;
  if (!second && message.len < entry->min_msg_len) return false;  // only MAVLink 2 may leave out trailing zeros

  std::uint16_t crc = crc_calculate(bytes + 1, static_cast<std::uint16_t>(header - 1 + message.len));
  crc_accumulate(entry->crc_extra, &crc);
  const std::uint8_t* checksum = bytes + header + message.len;
  if (checksum[0] != (crc & 0xFFU) || checksum[1] != crc >> 8U) return false;
  char* payload = _MAV_PAYLOAD_NON_CONST(&message);
  std::memcpy(payload, bytes + header, message.len);
  if (message.len < entry->max_msg_len) std::memset(payload + message.len, 0, entry->max_msg_len - message.len);
  return true;
}

template <class Packed>
Packed unpack(const mavlink_message_t& message, void (*decode)(const mavlink_message_t*, Packed*)) {
  Packed packed;
  decode(&message, &packed);
  return packed;
}

template <std::size_t N>
Text<N> text(const char* chars) {
  Text<N> out;
  for (std::size_t i = 0; i < N && chars[i] != '\0'; ++i) out.chars[i] = chars[i];
  return out;
}

template <class Packed>  // MISSION_ITEM and MISSION_ITEM_INT alike, but for x and y
MissionItemMessage item_message(const Packed& m) {
  MissionItemMessage out;
  out.seq = m.seq;
  out.item.p = {m.param1, m.param2, m.param3, m.param4};
  out.item.z = m.z;
  out.item.command = m.command;
  out.item.frame = m.frame;
  out.item.autocontinue = m.autocontinue;
  out.current = m.current;
  out.type = m.mission_type;
  return out;
}

/// Standard deviations of position and attitude from the upper triangle of a 6 x 6 covariance; 0 where it says nothing.
void read_covariance(const float (&covariance)[21], PoseFix& pose) {
  const auto deviations = [&](std::size_t x, std::size_t y, std::size_t z) {
    const Vec3 variance(covariance[x], covariance[y], covariance[z]);
    const bool known = variance.minCoeff() > 0.F && variance.allFinite();
    return known ? Vec3(variance.cwiseSqrt()) : Vec3(Vec3::Zero());
  };
  pose.position_deviation = deviations(0, 6, 11);
  pose.attitude_deviation = deviations(15, 18, 20);
}

template <class Packed>  // the local and the global one alike, but for the position
PositionTarget position_target(const Packed& m) {
  PositionTarget out;
  out.time_boot_ms = m.time_boot_ms;
  out.type_mask = m.type_mask;
  out.frame = m.coordinate_frame;
  out.velocity = from_wire(Vec3{m.vx, m.vy, m.vz});
  out.acceleration = from_wire(Vec3{m.afx, m.afy, m.afz});
  out.yaw = -m.yaw;  // clockwise on the wire
  out.yaw_rate = -m.yaw_rate;
  return out;
}

Message decode(const mavlink_message_t& message, Address& target) {
  const auto to = [&target](const auto& m) { target = {m.target_system, m.target_component}; };
  switch (message.msgid) {
    case MAVLINK_MSG_ID_HEARTBEAT: {
      const auto m = unpack(message, mavlink_msg_heartbeat_decode);
      return Heartbeat{m.type, m.autopilot, m.base_mode, m.system_status, m.custom_mode};
    }
    case MAVLINK_MSG_ID_COMMAND_LONG: {
      const auto m = unpack(message, mavlink_msg_command_long_decode);
      to(m);
      Command out;
      out.command = m.command;
      out.p = {m.param1, m.param2, m.param3, m.param4, m.param5, m.param6, m.param7};
      out.confirmation = m.confirmation;
      return out;
    }
    case MAVLINK_MSG_ID_COMMAND_INT: {
      const auto m = unpack(message, mavlink_msg_command_int_decode);
      to(m);
      Command out;
      out.command = m.command;
      out.p = {m.param1, m.param2, m.param3, m.param4, 0.F, 0.F, m.z};
      out.is_int = true;
      out.frame = m.frame;
      out.x = m.x;
      out.y = m.y;
      return out;
    }
    case MAVLINK_MSG_ID_SET_MODE: {
      const auto m = unpack(message, mavlink_msg_set_mode_decode);
      target = {m.target_system, 0};
      return SetMode{m.base_mode, m.custom_mode};
    }
    case MAVLINK_MSG_ID_SET_GPS_GLOBAL_ORIGIN: {
      const auto m = unpack(message, mavlink_msg_set_gps_global_origin_decode);
      target = {m.target_system, 0};
      return SetGlobalOrigin{m.latitude, m.longitude, m.altitude};
    }
    case MAVLINK_MSG_ID_PARAM_REQUEST_LIST: {
      to(unpack(message, mavlink_msg_param_request_list_decode));
      return ParamRequestList{};
    }
    case MAVLINK_MSG_ID_PARAM_REQUEST_READ: {
      const auto m = unpack(message, mavlink_msg_param_request_read_decode);
      to(m);
      return ParamRequestRead{text<16>(m.param_id), m.param_index};
    }
    case MAVLINK_MSG_ID_PARAM_SET: {
      const auto m = unpack(message, mavlink_msg_param_set_decode);
      to(m);
      return ParamSet{text<16>(m.param_id), m.param_value, m.param_type};
    }
    case MAVLINK_MSG_ID_MISSION_REQUEST_LIST: {
      const auto m = unpack(message, mavlink_msg_mission_request_list_decode);
      to(m);
      return MissionRequestList{m.mission_type};
    }
    case MAVLINK_MSG_ID_MISSION_REQUEST: {
      const auto m = unpack(message, mavlink_msg_mission_request_decode);
      to(m);
      return MissionRequest{{}, m.seq, m.mission_type, false};
    }
    case MAVLINK_MSG_ID_MISSION_REQUEST_INT: {
      const auto m = unpack(message, mavlink_msg_mission_request_int_decode);
      to(m);
      return MissionRequest{{}, m.seq, m.mission_type, true};
    }
    case MAVLINK_MSG_ID_MISSION_COUNT: {
      const auto m = unpack(message, mavlink_msg_mission_count_decode);
      to(m);
      return MissionCount{{}, m.count, m.mission_type, m.opaque_id};
    }
    case MAVLINK_MSG_ID_MISSION_ITEM_INT: {
      const auto m = unpack(message, mavlink_msg_mission_item_int_decode);
      to(m);
      MissionItemMessage out = item_message(m);
      out.item.x = m.x;
      out.item.y = m.y;
      return out;
    }
    case MAVLINK_MSG_ID_MISSION_ITEM: {
      const auto m = unpack(message, mavlink_msg_mission_item_decode);
      to(m);
      MissionItemMessage out = item_message(m);
      const std::int64_t factor = m.frame == kFrameMission ? 1 : 10000000;  // without a place x and y are plain numbers
      out.item.x = scaled_or_not_given(m.x, factor);
      out.item.y = scaled_or_not_given(m.y, factor);
      out.as_int = false;
      return out;
    }
    case MAVLINK_MSG_ID_MISSION_CLEAR_ALL: {
      const auto m = unpack(message, mavlink_msg_mission_clear_all_decode);
      to(m);
      return MissionClearAll{m.mission_type};
    }
    case MAVLINK_MSG_ID_MISSION_SET_CURRENT: {
      const auto m = unpack(message, mavlink_msg_mission_set_current_decode);
      to(m);
      return MissionSetCurrent{m.seq};
    }
    case MAVLINK_MSG_ID_MISSION_ACK: {
      const auto m = unpack(message, mavlink_msg_mission_ack_decode);
      to(m);
      return MissionAck{{}, static_cast<MissionResult>(m.type), m.mission_type, m.opaque_id};
    }
    case MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST: {
      const auto m = unpack(message, mavlink_msg_mission_write_partial_list_decode);
      to(m);
      return MissionWritePartial{m.start_index, m.end_index, m.mission_type};
    }
    case MAVLINK_MSG_ID_MISSION_REQUEST_PARTIAL_LIST: {
      const auto m = unpack(message, mavlink_msg_mission_request_partial_list_decode);
      to(m);
      return MissionRequestPartial{m.mission_type};
    }
    case MAVLINK_MSG_ID_SET_ATTITUDE_TARGET: {
      const auto m = unpack(message, mavlink_msg_set_attitude_target_decode);
      to(m);
      SetAttitudeTarget out;
      out.time_boot_ms = m.time_boot_ms;
      out.type_mask = m.type_mask;
      out.q_WD = from_wire(Quat{m.q[0], m.q[1], m.q[2], m.q[3]});
      out.w_WD_D = from_wire(Vec3{m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate});
      out.thrust = m.thrust;
      return out;
    }
    case MAVLINK_MSG_ID_ODOMETRY: {
      const auto m = unpack(message, mavlink_msg_odometry_decode);
      ExternalPose out;
      out.frame = m.frame_id;
      out.pose.t_us = m.time_usec;
      out.pose.p_WB = from_wire(Vec3{m.x, m.y, m.z});
      out.pose.q_WB = from_wire(Quat{m.q[0], m.q[1], m.q[2], m.q[3]});
      out.pose.resets = m.reset_counter;
      read_covariance(m.pose_covariance, out.pose);
      return out;
    }
    case MAVLINK_MSG_ID_ATT_POS_MOCAP: {
      const auto m = unpack(message, mavlink_msg_att_pos_mocap_decode);
      ExternalPose out;
      out.pose.t_us = m.time_usec;
      out.pose.p_WB = from_wire(Vec3{m.x, m.y, m.z});
      out.pose.q_WB = from_wire(Quat{m.q[0], m.q[1], m.q[2], m.q[3]});
      read_covariance(m.covariance, out.pose);
      return out;
    }
    case MAVLINK_MSG_ID_VISION_POSITION_ESTIMATE: {
      const auto m = unpack(message, mavlink_msg_vision_position_estimate_decode);
      const Vec3 turned(m.roll, m.pitch, m.yaw);
      const bool angles = turned.allFinite() && turned.cwiseAbs().maxCoeff() < kMostAngle;
      ExternalPose out;
      out.pose.t_us = m.usec;
      out.pose.p_WB = from_wire(Vec3{m.x, m.y, m.z});
      out.pose.q_WB = angles ? quat_from_wire_angles(m.roll, m.pitch, m.yaw) : Quat{0.F, 0.F, 0.F, 0.F};
      out.pose.resets = m.reset_counter;
      read_covariance(m.covariance, out.pose);
      return out;
    }
    case MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: {
      const auto m = unpack(message, mavlink_msg_set_position_target_local_ned_decode);
      to(m);
      PositionTarget out = position_target(m);
      out.position = from_wire(Vec3{m.x, m.y, m.z});
      return out;
    }
    case MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: {
      const auto m = unpack(message, mavlink_msg_set_position_target_global_int_decode);
      to(m);
      PositionTarget out = position_target(m);
      out.global = true;
      out.x = m.lat_int;
      out.y = m.lon_int;
      out.alt = m.alt;
      return out;
    }
    case MAVLINK_MSG_ID_TIMESYNC: {
      const auto m = unpack(message, mavlink_msg_timesync_decode);
      return Timesync{m.tc1, m.ts1};
    }
    case MAVLINK_MSG_ID_PING: {
      const auto m = unpack(message, mavlink_msg_ping_decode);
      to(m);
      return Ping{{m.target_system, m.target_component}, m.time_usec, m.seq};
    }
    case MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: {
      const auto m = unpack(message, mavlink_msg_file_transfer_protocol_decode);
      to(m);
      FileTransfer out;
      std::memcpy(out.payload.data(), m.payload, sizeof m.payload);
      return out;
    }
    case MAVLINK_MSG_ID_SETUP_SIGNING: {
      const auto m = unpack(message, mavlink_msg_setup_signing_decode);
      to(m);
      SetupSigning out;
      std::memcpy(out.key.data(), m.secret_key, sizeof m.secret_key);
      out.initial_stamp = m.initial_timestamp;
      return out;
    }
    case MAVLINK_MSG_ID_STATUSTEXT: {
      const auto m = unpack(message, mavlink_msg_statustext_decode);
      return StatusText{static_cast<Severity>(m.severity), text<50>(m.text)};
    }
    default: return Unhandled{message.msgid};
  }
}

}  // namespace

void Parser::push(std::uint8_t byte) {
  if (size_ == 0 && byte != MAVLINK_STX && byte != MAVLINK_STX_MAVLINK1) return;
  bytes_[size_++] = byte;
}

void Parser::drop(std::size_t count) {
  std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(count), bytes_.begin() + static_cast<std::ptrdiff_t>(size_),
            bytes_.begin());
  size_ -= count;
}

std::optional<Received> Parser::next(Endpoint from) {
  drop(used_);
  used_ = 0;
  while (size_ > 0) {
    const std::size_t wanted = frame_size(bytes_.data(), size_);
    if (wanted == kNotAFrame) {
      drop(1);
      continue;
    }
    if (wanted == kSizeUnknown || size_ < wanted) {
      look_at_ = std::max(wanted, size_ + 1);
      return std::nullopt;
    }
    mavlink_message_t message;
    if (!read_frame(bytes_.data(), message)) {
      ++bad_frames_;
      drop(1);
      continue;
    }
    used_ = wanted;
    Received out;
    out.header.sender = {message.sysid, message.compid};
    out.header.from = from;
    out.message = decode(message, out.header.target);
    out.id = message.msgid;
    out.sequence = message.seq;
    out.is_signed = message.magic == MAVLINK_STX && (message.incompat_flags & MAVLINK_IFLAG_SIGNED) != 0;
    out.frame = bytes_.data();
    out.frame_size = wanted;
    return out;
  }
  look_at_ = 1;
  return std::nullopt;
}

}  // namespace halfroll::link
