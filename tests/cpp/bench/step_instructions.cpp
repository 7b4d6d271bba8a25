// Instructions of each firmware step while every client talks in every millisecond. Why: the 1 kHz loop is as late as
// its worst step, and a counted instruction is the same on a busy machine. Valgrind counts
// (tests/bench/link_figures.py).
#include <development/mavlink.h>

#include <cstdlib>
#include <vector>

#include "autopilot.hpp"
#include "sim/sitl/scenario_file.hpp"
#include "sim/sitl/sensed.hpp"
#include "sim/sitl/vehicle_file.hpp"
#include "sim/world.hpp"

namespace {

using namespace halfroll;

constexpr float kHover = 0.571F * 9.80665F / 12.F;

using Bytes = std::vector<std::uint8_t>;

/// One client: its own sequence of frames.
struct Client {
  std::uint8_t system, component;
  link::Endpoint from;
  mavlink_status_t status = {};
  Bytes bytes;

  template <class Packed>
  void say(const Packed& packed,
           std::uint16_t (*encode)(std::uint8_t, std::uint8_t, mavlink_status_t*, mavlink_message_t*, const Packed*)) {
    mavlink_message_t message = {};
    encode(system, component, &status, &message, &packed);
    const std::size_t before = bytes.size();
    bytes.resize(before + MAVLINK_MAX_PACKET_LEN);
    bytes.resize(before + mavlink_msg_to_send_buffer(bytes.data() + before, &message));
  }
};

void command(Client& client, std::uint16_t number, float p1, float p2 = 0.F, float p3 = 0.F, float p7 = 0.F) {
  mavlink_command_long_t m = {};
  m.target_system = m.target_component = 1;
  m.command = number;
  m.param1 = p1;
  m.param2 = p2;
  m.param3 = p3;
  m.param7 = p7;
  client.say(m, mavlink_msg_command_long_encode_status);
}

/// The flight, and who talks, each on a link of its own: the ground station's setpoints, a GCS that uploads a mission
/// and a companion that asks things.
struct Flight {
  sitl::VehicleSetup setup = sitl::make_vehicle("mit-vp", {});
  Autopilot autopilot{setup.vehicle, setup.params};
  sim::Model model{setup.plant, sitl::make_scenario("nominal")};
  sim::World world = sim::start(model, 1);
  Client ground{1, 191, {0, 0}, {}, {}}, uploader{255, 190, {1, 0}, {}, {}}, asker{254, 190, {2, 1}, {}, {}};
  std::vector<link::Datagram> rx;
  std::uint16_t item = 0;
  link::StorageResult stored;

  void run(int steps) {
    for (int n = 0; n < steps; ++n) {
      Inputs in = sitl::sensed(world);
      in.link.wall_us = world.t_us;
      in.link.stored = stored;
      rx.clear();
      for (const Client* client : {&ground, &uploader, &asker}) {
        if (!client->bytes.empty()) rx.push_back({client->from, client->bytes.data(), client->bytes.size()});
      }
      in.link.rx = rx.data();
      in.link.rx_count = rx.size();
      const Outputs out = autopilot.step(in);
      stored = {out.link.store.slot, true};
      sim::step(model, world, out.rotors);
      for (Client* client : {&ground, &uploader, &asker}) client->bytes.clear();
    }
  }

  void take_off() {
    run(1500);
    command(asker, MAV_CMD_NAV_TAKEOFF, 0.F, 0.F, 0.F, 10.F);
    command(asker, MAV_CMD_COMPONENT_ARM_DISARM, 1.F);
    run(12000);
    command(asker, MAV_CMD_DO_SET_MODE, 1.F, 6.F);
  }

  /// In every millisecond a setpoint, a mission item and a question.
  void talk() {
    mavlink_set_attitude_target_t setpoint = {};
    setpoint.target_system = setpoint.target_component = 1;
    setpoint.time_boot_ms = static_cast<std::uint32_t>(autopilot.t_us() / 1000);
    setpoint.q[0] = 1.F;
    setpoint.thrust = kHover;
    ground.say(setpoint, mavlink_msg_set_attitude_target_encode_status);
    if (item == 0) {
      mavlink_mission_count_t count = {};
      count.target_system = count.target_component = 1;
      count.count = 200;
      uploader.say(count, mavlink_msg_mission_count_encode_status);
    } else {
      mavlink_mission_item_int_t wanted = {};
      wanted.target_system = wanted.target_component = 1;
      wanted.seq = static_cast<std::uint16_t>(item - 1);
      wanted.command = MAV_CMD_NAV_WAYPOINT;
      wanted.frame = MAV_FRAME_GLOBAL_RELATIVE_ALT;
      wanted.x = 473977420;
      wanted.y = 85455940;
      wanted.z = 10.F;
      uploader.say(wanted, mavlink_msg_mission_item_int_encode_status);
    }
    item = static_cast<std::uint16_t>((item + 1) % 201);
    mavlink_param_request_read_t read = {};
    read.target_system = read.target_component = 1;
    read.param_index = static_cast<std::int16_t>(item % 40);
    asker.say(read, mavlink_msg_param_request_read_encode_status);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Flight flight;
  flight.take_off();
  for (int n = argc > 1 ? std::atoi(argv[1]) : 4000; n > 0; --n) {
    flight.talk();
    flight.run(1);
  }
  return flight.autopilot.mode() == Mode::kOffboard ? 0 : 1;
}
