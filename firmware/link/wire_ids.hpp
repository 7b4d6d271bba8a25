// Numbers of the public MAVLink definitions that code refers to. Why: the generated headers stay inside the codec.
#pragma once
#include <cstdint>

#include "core/modes.hpp"

namespace halfroll::link {

/// MAV_RESULT.
enum class CommandResult : std::uint8_t { kAccepted, kTemporarilyRejected, kDenied, kUnsupported, kFailed };

/// MAV_MISSION_RESULT.
enum class MissionResult : std::uint8_t {
  kAccepted,
  kError,
  kUnsupportedFrame,
  kUnsupported,
  kNoSpace,
  kInvalid,
  kInvalidParam1,
  kInvalidParam2,
  kInvalidParam3,
  kInvalidParam4,
  kInvalidParam5,
  kInvalidParam6,
  kInvalidParam7,
  kInvalidSequence,
  kDenied,
  kOperationCancelled
};

/// MAV_PARAM_ERROR.
enum class ParamErrorCode : std::uint8_t {
  kDoesNotExist = 1,
  kOutOfRange = 2,
  kPermissionDenied = 3,
  kReadOnly = 5,
  kTypeMismatch = 7
};

/// MAV_SEVERITY.
enum class Severity : std::uint8_t { kEmergency, kAlert, kCritical, kError, kWarning, kNotice, kInfo, kDebug };

/// MAV_MISSION_TYPE.
inline constexpr std::uint8_t kTypeMission = 0, kTypeFence = 1, kTypeRally = 2, kTypeAll = 255;

inline constexpr std::uint8_t kAutopilotComponent = 1;    // ours
inline constexpr std::uint8_t kGroundComponent = 191;     // the ground station that streams references
inline constexpr std::uint8_t kGroundControlStation = 6;  // MAV_TYPE_GCS
inline constexpr std::uint8_t kParamReal32 = 9;           // MAV_PARAM_TYPE_REAL32

/// MAV_FRAME, the ones taken here.
inline constexpr std::uint8_t kFrameGlobal = 0, kFrameMission = 2, kFrameRelative = 3, kFrameGlobalInt = 5,
                              kFrameRelativeInt = 6, kFrameBody = 8;
/// Frames of poses: LOCAL_NED; what older clients call MOCAP_NED and VISION_NED; LOCAL_FRD, whose forward the room's
/// owner has laid along W's north.
inline constexpr std::uint8_t kFrameLocalNed = 1, kFrameMocapNed = 14, kFrameVisionNed = 16, kFrameLocalFrd = 20;
constexpr bool is_pose_frame(std::uint8_t frame) {
  return frame == kFrameLocalNed || frame == kFrameMocapNed || frame == kFrameVisionNed || frame == kFrameLocalFrd;
}

/// MAV_CMD.
namespace cmd {
inline constexpr std::uint16_t kWaypoint = 16, kLoiterUnlimited = 17, kLoiterTime = 19, kReturnToLaunch = 20,
                               kLand = 21, kTakeoff = 22, kSplineWaypoint = 82, kDelay = 93, kConditionDelay = 112,
                               kConditionYaw = 115, kSetMode = 176, kJump = 177, kChangeSpeed = 178, kSetHome = 179,
                               kFlightTermination = 185, kLandStart = 189, kReposition = 192, kPauseContinue = 193,
                               kInvertedFlight = 210, kSetMissionCurrent = 224, kCalibration = 241,
                               kPreflightStorage = 245, kReboot = 246, kSetStandardMode = 262, kMissionStart = 300,
                               kArmDisarm = 400, kRunPrearmChecks = 401, kGetHomePosition = 410,
                               kGetMessageInterval = 510, kSetMessageInterval = 511, kRequestMessage = 512,
                               kRequestCapabilities = 520, kSetGlobalOrigin = 611, kAttitudeWaypoint = 31000,
                               kFlip = 31010;
}  // namespace cmd

/// Message ids.
namespace msg {
inline constexpr std::uint32_t kHeartbeat = 0, kSysStatus = 1, kSystemTime = 2, kRadioStatus = 109, kGpsRawInt = 24,
                               kAttitude = 30, kAttitudeQuaternion = 31, kLocalPosition = 32, kGlobalPositionInt = 33,
                               kMissionCurrent = 42, kGpsGlobalOrigin = 49, kVfrHud = 74, kAttitudeTarget = 83,
                               kHighresImu = 105, kAltitude = 141, kBatteryStatus = 147, kAutopilotVersion = 148,
                               kHomePosition = 242, kMessageInterval = 244, kExtendedSysState = 245, kOdometry = 331,
                               kActuatorOutputStatus = 375, kAvailableModes = 435, kCurrentMode = 436,
                               kAvailableModesMonitor = 437;
}  // namespace msg

/// The flight modes as the wire numbers them, in the order of Mode; AVAILABLE_MODES counts them from 1.
using WireMode = Mode;
struct WireModeRow {
  Mode mode;
  std::uint32_t custom_mode;
  std::uint8_t standard_mode;
  std::uint32_t properties;
  const char* name;
};
inline constexpr WireModeRow kWireModes[] = {
    {Mode::kHold, 50593792, 0, 0, "Hold"},       {Mode::kMission, 67371008, 6, 0, "Mission"},
    {Mode::kReturn, 84148224, 5, 0, "Return"},   {Mode::kLand, 100925440, 7, 0, "Land"},
    {Mode::kTakeoff, 33816576, 8, 0, "Takeoff"}, {Mode::kOffboard, 393216, 0, 1, "Offboard"},
};
inline constexpr int kWireModeCount = kModeCount;
constexpr const WireModeRow& wire_mode(Mode mode) { return kWireModes[static_cast<int>(mode)]; }

}  // namespace halfroll::link
