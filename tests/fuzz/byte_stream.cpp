// Any bytes on any link, into a vehicle on the ground, in hover, on a mission, or hovering behind links that want
// signatures. The first byte is the situation; of each frame, the compatibility flags say after how many milliseconds
// it comes, and the sequence number on which link, from whom and how it is signed.
#include "flying_vehicle.hpp"
#include "signatures.hpp"

namespace {

using namespace halfroll;
using namespace halfroll::fuzz;

constexpr int kLongestMs = 400;
constexpr std::uint64_t kUnixUs = 1767225600000000U;                   // when the signing vehicle boots
constexpr std::uint64_t kStamp = (kUnixUs - 1420070400000000U) / 10U;  // the same as signatures count

/// Link A takes signed frames only, B both, and C may set the key.
Boot with_signing() {
  Boot boot;
  boot.unix_us_at_wall_0 = kUnixUs;
  boot.signing_policies = {link::SigningPolicy::kRequire, link::SigningPolicy::kAccept, link::SigningPolicy::kTrusted};
  boot.signing_key = kKey;
  return boot;
}

struct Situations {
  FlyingVehicle grounded, hovering, on_mission, signing{with_signing()};

  Situations() {
    signing.fly(1500);
    grounded.fly(1500);
    hovering = grounded;
    auto count = to_autopilot<mavlink_mission_count_t>();
    count.count = 3;
    hovering.step(frame(count, mavlink_msg_mission_count_encode_status));
    for (std::uint16_t seq = 0; seq < 3; ++seq) hovering.step(waypoint(seq, 900 * seq, 450 * seq * seq, 10.F));
    hovering.take_off();
    on_mission = hovering;
    on_mission.step(command(MAV_CMD_MISSION_START, 0.F));
    on_mission.fly(2500);
    if (on_mission.autopilot().mode() != Mode::kMission) fail("the mission has not begun", 0);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Situations situations;
  if (size < 2) return 0;
  const std::uint8_t situation = data[0] % 4;
  FlyingVehicle vehicle = situation == 0   ? situations.grounded
                          : situation == 1 ? situations.hovering
                          : situation == 2 ? situations.on_mission
                                           : situations.signing;
  std::uint64_t stamp = kStamp;
  int left_ms = kLongestMs;
  for (const Bytes& piece : pieces(data + 1, size - 1)) {
    const bool is_frame = looks_like_a_frame(piece);
    const int wait_ms = is_frame ? piece[3] : 0;
    if ((left_ms -= wait_ms + 1) < 0) break;
    vehicle.fly(wait_ms);
    const auto link = static_cast<std::uint8_t>(is_frame ? piece[4] % link::kLinkCount : 1);
    const link::Endpoint from{link, static_cast<std::uint8_t>(is_frame ? piece[4] / 4 % 4 : 0)};
    if (situation == 3 && is_frame) {
      stamp += (piece[4] & 64U) / 64U;  // or the one before again
      const auto how = static_cast<Signature>((piece[4] >> 4U) % 4);
      vehicle.step(signed_as(piece, how, piece[4] / 128, stamp), from);
    } else {
      vehicle.step(piece, from);
    }
  }
  vehicle.fly(20);
  return 0;
}
