// Sending: replies and announcements.
#include <cstring>

#include "link/codec_mavlink.hpp"

namespace halfroll::link {

TxFrame encode(const CommandAck& in, Envelope envelope) {
  mavlink_command_ack_t m = {};
  m.command = in.command;
  m.result = static_cast<std::uint8_t>(in.result);
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  return to_frame(m, envelope, mavlink_msg_command_ack_encode_status);
}

TxFrame encode(const StatusText& in, Envelope envelope) {
  mavlink_statustext_t m = {};
  m.severity = static_cast<std::uint8_t>(in.severity);
  std::memcpy(m.text, in.text.c_str(), sizeof m.text);
  return to_frame(m, envelope, mavlink_msg_statustext_encode_status);
}

TxFrame encode(const ParamValue& in, Envelope envelope) {
  mavlink_param_value_t m = {};
  std::memcpy(m.param_id, in.id.c_str(), sizeof m.param_id);
  m.param_value = in.value;
  m.param_type = kParamReal32;
  m.param_count = in.count;
  m.param_index = in.index;
  return to_frame(m, envelope, mavlink_msg_param_value_encode_status);
}

TxFrame encode(const ParamRefusal& in, Envelope envelope) {
  mavlink_param_error_t m = {};
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  std::memcpy(m.param_id, in.id.c_str(), sizeof m.param_id);
  m.param_index = in.index;
  m.error = static_cast<std::uint8_t>(in.error);
  return to_frame(m, envelope, mavlink_msg_param_error_encode_status);
}

TxFrame encode(const MissionCount& in, Envelope envelope) {
  mavlink_mission_count_t m = {};
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  m.count = in.count;
  m.mission_type = in.type;
  m.opaque_id = in.opaque_id;
  return to_frame(m, envelope, mavlink_msg_mission_count_encode_status);
}

namespace {

template <class Packed>
void fill_item(Packed& m, const MissionItemMessage& in) {
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  m.seq = in.seq;
  m.frame = in.item.frame;
  m.command = in.item.command;
  m.current = in.current;
  m.autocontinue = in.item.autocontinue;
  m.param1 = in.item.p[0];
  m.param2 = in.item.p[1];
  m.param3 = in.item.p[2];
  m.param4 = in.item.p[3];
  m.z = in.item.z;
  m.mission_type = in.type;
}

}  // namespace

TxFrame encode(const MissionItemMessage& in, Envelope envelope) {
  if (in.as_int) {
    mavlink_mission_item_int_t m = {};
    fill_item(m, in);
    m.x = in.item.x;
    m.y = in.item.y;
    return to_frame(m, envelope, mavlink_msg_mission_item_int_encode_status);
  }
  mavlink_mission_item_t m = {};
  fill_item(m, in);
  const bool plain = in.item.frame == kFrameMission;  // without a place x and y are plain numbers
  m.x = plain ? static_cast<float>(in.item.x) : from_degE7(in.item.x);
  m.y = plain ? static_cast<float>(in.item.y) : from_degE7(in.item.y);
  return to_frame(m, envelope, mavlink_msg_mission_item_encode_status);
}

TxFrame encode(const MissionRequest& in, Envelope envelope) {  // always INT: the older one is refused by clients
  mavlink_mission_request_int_t m = {};
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  m.seq = in.seq;
  m.mission_type = in.type;
  return to_frame(m, envelope, mavlink_msg_mission_request_int_encode_status);
}

TxFrame encode(const MissionAck& in, Envelope envelope) {
  mavlink_mission_ack_t m = {};
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  m.type = static_cast<std::uint8_t>(in.result);
  m.mission_type = in.type;
  m.opaque_id = in.opaque_id;
  return to_frame(m, envelope, mavlink_msg_mission_ack_encode_status);
}

TxFrame encode(const MissionItemReached& in, Envelope envelope) {
  mavlink_mission_item_reached_t m = {};
  m.seq = in.seq;
  return to_frame(m, envelope, mavlink_msg_mission_item_reached_encode_status);
}

TxFrame encode(const MessageInterval& in, Envelope envelope) {
  mavlink_message_interval_t m = {};
  m.message_id = in.id;
  m.interval_us = in.interval_us;
  return to_frame(m, envelope, mavlink_msg_message_interval_encode_status);
}

TxFrame encode(const Timesync& in, Envelope envelope) {
  mavlink_timesync_t m = {};
  m.tc1 = in.tc1;
  m.ts1 = in.ts1;
  return to_frame(m, envelope, mavlink_msg_timesync_encode_status);
}

TxFrame encode(const Ping& in, Envelope envelope) {
  mavlink_ping_t m = {};
  m.time_usec = in.time_us;
  m.seq = in.seq;
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  return to_frame(m, envelope, mavlink_msg_ping_encode_status);
}

TxFrame encode(const FileTransfer& in, Envelope envelope) {
  mavlink_file_transfer_protocol_t m = {};
  m.target_system = in.target.system;
  m.target_component = in.target.component;
  std::memcpy(m.payload, in.payload.data(), sizeof m.payload);
  return to_frame(m, envelope, mavlink_msg_file_transfer_protocol_encode_status);
}

}  // namespace halfroll::link
