// What comes and goes, as plain structs. Why: everything past the codec speaks SI, north-west-up and forward-left-up;
// only mission items, commands and origins keep the wire's integers, because they must be returned bit by bit.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <variant>

#include "core/types.hpp"
#include "link/datagram.hpp"
#include "link/wire_ids.hpp"

namespace halfroll::link {

inline constexpr Endpoint kToAll{kAllLinks, kEveryone};
constexpr Endpoint everyone_on(int link) { return {static_cast<std::uint8_t>(link), kEveryone}; }

/// Whom a message is for, or who sent it.
struct Address {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  bool operator==(const Address& o) const { return system == o.system && component == o.component; }
};

/// Envelope of a received frame. Messages without target fields have target 0/0.
struct Header {
  Address sender;
  Address target;
  Endpoint from;
  bool operator==(const Header& o) const { return sender == o.sender && target == o.target && from == o.from; }
};

/// Text of at most 16 (parameter) or 50 (status) characters, always terminated here.
template <std::size_t N>
struct Text {
  std::array<char, N + 1> chars = {};
  Text() = default;
  Text(const char* text) {  // NOLINT: a literal is a text
    for (std::size_t i = 0; i < N && text[i] != '\0'; ++i) chars[i] = text[i];
  }
  const char* c_str() const { return chars.data(); }
  bool operator==(const Text& o) const { return chars == o.chars; }
};

struct Heartbeat {
  std::uint8_t type = 0, autopilot = 0, base_mode = 0, system_status = 0;
  std::uint32_t custom_mode = 0;
};

/// COMMAND_LONG and COMMAND_INT alike. p[0..6] are params 1..7; for INT, p[4] and p[5] are unused and x, y hold
/// integers.
struct Command {
  std::uint16_t command = 0;
  std::array<float, 7> p = {};
  bool is_int = false;
  std::uint8_t frame = 0;         // INT only
  std::int32_t x = 0, y = 0;      // INT only
  std::uint8_t confirmation = 0;  // LONG only
};
struct SetMode {
  std::uint8_t base_mode = 0;
  std::uint32_t custom_mode = 0;
};
struct SetGlobalOrigin {  // message 48: lat, lon in 1e-7 degrees, altitude in mm
  std::int32_t lat = 0, lon = 0, alt_mm = 0;
};

struct ParamRequestList {};
struct ParamRequestRead {
  Text<16> id;
  std::int16_t index = -1;
};
struct ParamSet {
  Text<16> id;
  float value = 0.F;
  std::uint8_t type = kParamReal32;
};

/// A mission item as stored: exactly what came, 32 bytes without padding.
struct MissionItem {
  std::array<float, 4> p = {};
  std::int32_t x = 0, y = 0;  // 1e-7 degrees in every global frame number
  float z = 0.F;
  std::uint16_t command = 0;
  std::uint8_t frame = 0;
  std::uint8_t autocontinue = 1;
  bool operator==(const MissionItem& o) const { return std::memcmp(this, &o, sizeof o) == 0; }  // NaN equals itself
};
static_assert(sizeof(MissionItem) == 32, "items are hashed and stored as bytes");

struct MissionRequestList {
  std::uint8_t type = kTypeMission;
};
struct MissionRequest {  // MISSION_REQUEST_INT, or the older MISSION_REQUEST
  Address target;
  std::uint16_t seq = 0;
  std::uint8_t type = kTypeMission;
  bool as_int = true;
};
struct MissionCount {
  Address target;
  std::uint16_t count = 0;
  std::uint8_t type = kTypeMission;
  std::uint32_t opaque_id = 0;
};
struct MissionItemMessage {  // MISSION_ITEM_INT, or MISSION_ITEM with float degrees
  Address target;
  std::uint16_t seq = 0;
  MissionItem item;
  std::uint8_t current = 0;
  std::uint8_t type = kTypeMission;
  bool as_int = true;
};
struct MissionClearAll {
  std::uint8_t type = kTypeMission;
};
struct MissionSetCurrent {
  std::uint16_t seq = 0;
};
struct MissionAck {
  Address target;
  MissionResult result = MissionResult::kAccepted;
  std::uint8_t type = kTypeMission;
  std::uint32_t opaque_id = 0;
};
struct MissionWritePartial {
  std::int16_t first = 0, last = 0;
  std::uint8_t type = kTypeMission;
};
struct MissionRequestPartial {
  std::uint8_t type = kTypeMission;
};

/// SET_ATTITUDE_TARGET in our frames. Nothing is checked: any field may be NaN.
struct SetAttitudeTarget {
  std::uint32_t time_boot_ms = 0;
  std::uint8_t type_mask = 0;
  Quat q_WD;
  Vec3 w_WD_D = Vec3::Zero();
  float thrust = 0.F;  // -1..1, signed, along body up
};
/// ODOMETRY, ATT_POS_MOCAP or VISION_POSITION_ESTIMATE in our frames; pose.t_us is the sender's stamp. Nothing is
/// checked.
struct ExternalPose {
  PoseFix pose;
  std::uint8_t frame = kFrameLocalNed;  // the wire's; only axes that are north-east-down or alike can be used
};
/// SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, axes turned to ours. Nothing is checked: any float may be NaN.
struct PositionTarget {
  std::uint32_t time_boot_ms = 0;
  std::uint16_t type_mask = 0;
  std::uint8_t frame = 0;
  bool global = false;           // x and y are lat, lon [1e-7 degrees], z is as the frame says [m]
  std::int32_t x = 0, y = 0;     // global only
  float alt = 0.F;               // global only
  Vec3 position = Vec3::Zero();  // local only
  Vec3 velocity = Vec3::Zero(), acceleration = Vec3::Zero();
  float yaw = 0.F, yaw_rate = 0.F;
};

struct Timesync {
  std::int64_t tc1 = 0, ts1 = 0;  // [ns]
};
struct Ping {
  Address target;
  std::uint64_t time_us = 0;
  std::uint32_t seq = 0;
};
struct FileTransfer {
  Address target;
  std::array<std::uint8_t, 251> payload = {};
};
struct StatusText {
  Severity severity = Severity::kInfo;
  Text<50> text;
};

struct SetupSigning {
  std::array<std::uint8_t, 32> key = {};
  std::uint64_t initial_stamp = 0;  // [10 us] since 2015
};

struct Unhandled {  // a good frame with nothing in it for us
  std::uint32_t id = 0;
};

using Message =
    std::variant<Unhandled, Heartbeat, Command, SetMode, SetGlobalOrigin, ParamRequestList, ParamRequestRead, ParamSet,
                 MissionRequestList, MissionRequest, MissionCount, MissionItemMessage, MissionClearAll,
                 MissionSetCurrent, MissionAck, MissionWritePartial, MissionRequestPartial, SetAttitudeTarget,
                 ExternalPose, PositionTarget, Timesync, Ping, FileTransfer, StatusText, SetupSigning>;

// Only sent:

struct CommandAck {
  Address target;
  std::uint16_t command = 0;
  CommandResult result = CommandResult::kAccepted;
};
struct ParamValue {
  Text<16> id;
  float value = 0.F;
  std::uint16_t count = 0, index = 0;
};
struct ParamRefusal {  // PARAM_ERROR
  Address target;
  Text<16> id;
  std::int16_t index = -1;
  ParamErrorCode error = ParamErrorCode::kDoesNotExist;
};
struct MissionItemReached {
  std::uint16_t seq = 0;
};
struct MessageInterval {
  std::uint16_t id = 0;
  std::int32_t interval_us = 0;  // -1 off, 0 not available
};

/// Target rule of the contract: ours, or everybody's; never what we sent ourselves.
constexpr bool is_for_us(const Header& header, std::uint8_t own_system) {
  const bool own_echo = header.sender.system == own_system && header.sender.component == kAutopilotComponent;
  const bool system_ok = header.target.system == 0 || header.target.system == own_system;
  const bool component_ok = header.target.component == 0 || header.target.component == kAutopilotComponent;
  return !own_echo && system_ok && component_ok;
}

}  // namespace halfroll::link
