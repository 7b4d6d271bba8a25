// Two clients that upload, download, overwrite, clear and contradict each other in any order, over a disk that may
// fail. Whatever is written to it must be one whole mission of one client, named by its own items.
#include <algorithm>
#include <cstring>

#include "frames.hpp"
#include "sim/sitl/checked.hpp"
#include "sim/sitl/vehicle_file.hpp"

namespace {

using namespace halfroll;
using namespace halfroll::fuzz;
using sitl::fail;

constexpr std::size_t kImageHeader = 12;  // magic, count, id
constexpr int kLongestMs = 6000;          // an upload is given up after 5 s

std::uint8_t system_of(std::uint8_t client) { return static_cast<std::uint8_t>(250 + client); }

/// The autopilot on a table, and its disk.
class Table {
 public:
  Table() : setup_(sitl::make_vehicle("mit-vp", {})), autopilot_(setup_.vehicle, setup_.params) {}

  void hear(std::uint8_t client, const Bytes& bytes) {
    const link::Datagram datagram{{client, 0}, bytes.data(), bytes.size()};
    LinkInputs in;
    in.rx = &datagram;
    in.rx_count = 1;
    in.stored = stored_;
    stored_ = {};
    settle(autopilot_.service(in));
  }
  void wait(int milliseconds) {
    for (int n = 0; n < milliseconds; ++n) {
      Inputs in;
      in.measured.imu.specific_force_B = {0.F, 0.F, kGravity};
      in.link.stored = stored_;
      stored_ = {};
      const Outputs out = sitl::checked_step(autopilot_, in);
      t_us_ += 1000;
      settle(out.link);
    }
  }
  void disk_works(bool does) { disk_works_ = does; }
  void somebody_overwrites_parts() { mixed_ = true; }

 private:
  void settle(const LinkOutputs& out) {
    if (const char* what = sitl::broken_frame(out)) fail(what, t_us_);
    if (out.store.slot == link::StorageSlot::kNone) return;
    if (out.store.slot == link::StorageSlot::kMission) check_image(out.store);
    stored_ = {out.store.slot, disk_works_};
  }

  void check_image(const link::StorageRequest& image) const {
    std::uint32_t count = 0, id = 0;
    if (image.size < kImageHeader) fail("a mission's image without its header", t_us_);
    std::memcpy(&count, image.bytes + 4, 4);
    std::memcpy(&id, image.bytes + 8, 4);
    if (image.size != kImageHeader + count * sizeof(link::MissionItem))
      fail("a mission's image of another size", t_us_);
    std::vector<link::MissionItem> items(count);
    if (count > 0) std::memcpy(items.data(), image.bytes + kImageHeader, count * sizeof(link::MissionItem));
    const int size = static_cast<int>(count);
    if (link::mission_id(items.data(), size) != id) fail("a stored mission that is not named by its items", t_us_);
    for (int seq = 0; seq < size; ++seq) {
      const auto& item = items[static_cast<std::size_t>(seq)];
      if (link::check_item(item, seq, 500.F) != link::MissionResult::kAccepted) fail("a stored item is invalid", t_us_);
      if (!mixed_ && item.p[0] != items[0].p[0]) fail("a stored mission of two clients", t_us_);
    }
  }

  sitl::VehicleSetup setup_;
  Autopilot autopilot_;
  link::StorageResult stored_;
  std::uint64_t t_us_ = 0;
  bool disk_works_ = true, mixed_ = false;
};

Bytes item(std::uint8_t client, std::uint16_t seq, Reader& more) {
  constexpr std::uint16_t kCommands[] = {16, 16, 16, 19, 20, 21, 22, 93, 112, 177, 178, 206, 31000, 31010, 9999};
  auto m = to_autopilot<mavlink_mission_item_int_t>();
  m.seq = seq;
  const std::uint8_t how = more.byte();
  m.command = kCommands[how < 200 ? 0 : how % std::size(kCommands)];
  m.param1 = client;  // a hold time, where it is one
  m.frame = how % 32 == 31 ? more.byte() : std::uint8_t{MAV_FRAME_GLOBAL_RELATIVE_ALT};
  m.autocontinue = 1;
  m.x = 473977420 + 100 * more.byte();
  m.y = 85455940;
  m.z = how % 32 == 30 ? 1e9F : 10.F;
  return frame(m, mavlink_msg_mission_item_int_encode_status, system_of(client));
}

Bytes count(std::uint8_t client, std::uint16_t number) {
  auto m = to_autopilot<mavlink_mission_count_t>();
  m.count = number;
  return frame(m, mavlink_msg_mission_count_encode_status, system_of(client));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Reader input(data, size);
  Table table;
  std::uint16_t next[2] = {0, 0};  // what each client would send, if it kept to the rules
  int left_ms = kLongestMs;
  while (!input.empty()) {
    const std::uint8_t op = input.byte();
    const std::uint8_t client = op >> 7U;
    switch (op & 15U) {
      case 0:
      case 1:
      case 2:
      case 3: table.hear(client, item(client, next[client]++, input)); break;
      case 4: table.hear(client, item(client, input.byte(), input)); break;
      case 5:
        next[client] = 0;
        table.hear(client, count(client, input.byte() % 24));
        break;
      case 6:
        next[client] = 0;
        table.hear(client, count(client, static_cast<std::uint16_t>(input.byte() * 16)));
        break;
      case 7: {
        auto m = to_autopilot<mavlink_mission_clear_all_t>();
        m.mission_type = input.byte();
        table.hear(client, frame(m, mavlink_msg_mission_clear_all_encode_status, system_of(client)));
        break;
      }
      case 8: {
        auto m = to_autopilot<mavlink_mission_request_list_t>();
        m.mission_type = input.byte() % 4;
        table.hear(client, frame(m, mavlink_msg_mission_request_list_encode_status, system_of(client)));
        break;
      }
      case 9: {
        auto m = to_autopilot<mavlink_mission_request_int_t>();
        m.seq = input.byte();
        table.hear(client, frame(m, mavlink_msg_mission_request_int_encode_status, system_of(client)));
        break;
      }
      case 10: {
        auto m = to_autopilot<mavlink_mission_write_partial_list_t>();
        m.start_index = static_cast<std::int16_t>(input.byte() - 8);
        m.end_index = static_cast<std::int16_t>(input.byte() - 8);
        next[client] = static_cast<std::uint16_t>(std::max<int>(m.start_index, 0));
        table.somebody_overwrites_parts();
        table.hear(client, frame(m, mavlink_msg_mission_write_partial_list_encode_status, system_of(client)));
        break;
      }
      case 11: {
        auto m = to_autopilot<mavlink_mission_ack_t>();
        m.type = input.byte();
        table.hear(client, frame(m, mavlink_msg_mission_ack_encode_status, system_of(client)));
        break;
      }
      case 12: table.disk_works(op < 64); break;
      case 13: {
        auto m = to_autopilot<mavlink_mission_set_current_t>();
        m.seq = input.byte();
        table.hear(client, frame(m, mavlink_msg_mission_set_current_encode_status, system_of(client)));
        break;
      }
      default: {
        const int wait_ms = 1 + 8 * input.byte();
        if ((left_ms -= wait_ms) < 0) return 0;
        table.wait(wait_ms);
      }
    }
  }
  return 0;
}
