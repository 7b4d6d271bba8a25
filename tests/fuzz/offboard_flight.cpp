// Any setpoints into a flying closed loop: attitude, rates, thrust; position, velocity, acceleration; poses from
// outside. A record is: what, how long until it comes [ms], a time stamp's offset, and the message's payload as it is.
#include "flying_vehicle.hpp"

namespace {

using namespace halfroll;
using namespace halfroll::fuzz;

constexpr std::uint32_t kMessages[] = {82, 84, 86, 331, 138, 102, 11, 76};
constexpr int kLongestMs = 600;

FlyingVehicle in_the_air() {
  FlyingVehicle vehicle;
  vehicle.fly(1500);
  vehicle.take_off();
  vehicle.step(command(MAV_CMD_DO_SET_MODE, 1.F, 6.F));
  vehicle.fly(5);
  if (vehicle.autopilot().mode() != Mode::kOffboard) fail("the vehicle does not take setpoints", 0);
  return vehicle;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FlyingVehicle flying = in_the_air();
  FlyingVehicle vehicle = flying;
  int left_ms = kLongestMs;
  for (std::size_t at = 0; at + 3 < size;) {
    const std::uint32_t id = kMessages[data[at] % std::size(kMessages)];
    const int wait_ms = data[at + 1] % 64;
    const std::size_t length = mavlink_get_msg_entry(id)->max_msg_len;
    Bytes payload(length);
    std::copy_n(data + at + 3, std::min(length, size - at - 3), payload.begin());
    if ((left_ms -= wait_ms + 1) < 0) break;
    vehicle.fly(wait_ms);
    if (id == 82 || id == 84 || id == 86) {  // a stamp near now, or what the input says
      const auto now_ms = static_cast<std::uint32_t>(vehicle.autopilot().t_us() / 1000);
      const std::uint32_t stamp = now_ms + data[at + 2] - 128;
      if (data[at + 2] != 0) std::copy_n(reinterpret_cast<const std::uint8_t*>(&stamp), 4, payload.begin());
    }
    vehicle.step(frame_of(id, payload), {0, 0});
    at += 3 + length;
  }
  vehicle.fly(40);
  return 0;
}
