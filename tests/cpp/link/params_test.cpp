// Parameters as both families of clients ask for them.
#include "link/params.hpp"

#include <cstring>
#include <limits>
#include <string>

#include "client.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

struct Vehicle {
  Params params;
  ParamService service;
  Outbox outbox;
  Header gcs = client::header(1, 2);

  std::vector<TxFrame> read(const char* id, int index = -1) {
    outbox.begin(1, 0);
    service.receive(ParamRequestRead{id, static_cast<std::int16_t>(index)}, gcs, params, outbox);
    return client::frames(outbox);
  }
  std::vector<TxFrame> set(const char* id, float value, std::uint8_t type = kParamReal32, bool armed = false) {
    outbox.begin(1, 0);
    service.receive(ParamSet{id, value, type}, gcs, armed, 1000, params, outbox);
    return client::frames(outbox);
  }
};

mavlink_param_value_t shown(const TxFrame& frame) { return client::read(frame, mavlink_msg_param_value_decode); }
int refusal(const TxFrame& frame) {
  CHECK(+client::read(frame).msgid == MAVLINK_MSG_ID_PARAM_ERROR);
  return client::read(frame, mavlink_msg_param_error_decode).error;
}

}  // namespace

TEST_CASE("a list brings each parameter once, 100 to 400 a second of wall time, to the asker") {
  Vehicle v;
  v.service.receive(ParamRequestList{}, v.gcs, 0);
  std::vector<int> indices;
  std::uint64_t wall_us = 0;
  for (; wall_us < 2000000 && indices.size() < kParamCount; wall_us += 10000) {
    v.outbox.begin(1, 0);
    v.service.service(wall_us, v.params, v.outbox);
    for (const TxFrame& frame : client::frames(v.outbox)) {
      CHECK(frame.to == v.gcs.from);
      CHECK(+shown(frame).param_count == kParamCount);
      indices.push_back(shown(frame).param_index);
    }
  }
  REQUIRE(indices.size() == kParamCount);
  for (int i = 0; i < kParamCount; ++i) CHECK(indices[static_cast<std::size_t>(i)] == i);
  const double rate_hz = kParamCount / (static_cast<double>(wall_us) * 1e-6);
  CHECK(rate_hz > 100);
  CHECK(rate_hz < 400);
}

TEST_CASE("a new list request starts again, and a read is answered meanwhile") {
  Vehicle v;
  v.service.receive(ParamRequestList{}, v.gcs, 0);
  v.outbox.begin(1, 0);
  v.service.service(20000, v.params, v.outbox);
  CHECK(v.outbox.size() > 1);
  CHECK(+shown(v.read("MIS_TAKEOFF_ALT").at(0)).param_value == 2.5F);
  v.service.receive(ParamRequestList{}, v.gcs, 30000);
  v.outbox.begin(1, 0);
  v.service.service(30000, v.params, v.outbox);
  CHECK(+shown(v.outbox.frames()[0]).param_index == 0);
}

TEST_CASE("a parameter is read by name or by index") {
  Vehicle v;
  const auto by_name = shown(v.read("RTL_RETURN_ALT").at(0));
  CHECK(+by_name.param_type == 9);
  CHECK(+by_name.param_value == 30.F);
  CHECK(+shown(v.read("", by_name.param_index).at(0)).param_value == 30.F);
}

TEST_CASE("a change is stored and shown to everybody") {
  Vehicle v;
  const auto frames = v.set("MIS_TAKEOFF_ALT", 7.F);
  REQUIRE(frames.size() == kLinkCount);
  CHECK(frames[0].to.slot == kEveryone);
  CHECK(+shown(frames[0]).param_value == 7.F);
  CHECK(v.params.takeoff_altitude == 7.F);
}

TEST_CASE("what is not there is error 1 with name and index echoed") {
  Vehicle v;
  const auto frames = v.read("_HASH_CHECK");
  REQUIRE(frames.size() == 1);
  const auto error = client::read(frames[0], mavlink_msg_param_error_decode);
  CHECK(+error.error == 1);
  CHECK(std::string(error.param_id) == "_HASH_CHECK");
  CHECK(+error.param_index == -1);
  CHECK(+error.target_system == 255);
  for (const int index : {kParamCount, 32767, -2, -32768}) CHECK(refusal(v.read("", index).at(0)) == 1);
  CHECK(v.set("NO_SUCH", 1.F).size() == 1);
  CHECK(refusal(v.set("NO_SUCH", 1.F).at(0)) == 1);
}

TEST_CASE("a refused change names its error first and then shows what holds, to the asker alone") {
  Vehicle v;
  struct Case {
    const char* id;
    float value;
    std::uint8_t type;
    int error;
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const Case& c : {Case{"MIS_TAKEOFF_ALT", kNan, 9, 2},
                        {"MIS_TAKEOFF_ALT", kInf, 9, 2},
                        {"MIS_TAKEOFF_ALT", 0.4F, 9, 2},
                        {"MIS_TAKEOFF_ALT", 101.F, 9, 2},
                        {"MAV_SYS_ID", 1.5F, 9, 2},
                        {"SIM_SPEED", 2.F, 9, 5},
                        {"VEH_T_REF", 2.F, 9, 5},
                        {"MIS_TAKEOFF_ALT", 3.F, 6, 7}}) {
    CAPTURE(c.id);
    const auto frames = v.set(c.id, c.value, c.type);
    REQUIRE(frames.size() == 2);
    CHECK(refusal(frames[0]) == c.error);
    CHECK(+shown(frames[1]).param_index == find_param(c.id));
    CHECK(frames[1].to == v.gcs.from);
  }
  CHECK(v.params.takeoff_altitude == 2.5F);
}

TEST_CASE("names of sixteen characters have no terminator on the wire") {
  ParamValue value;
  value.id = "ABCDEFGHIJKLMNOP";
  const auto m = client::read(encode(value, Envelope{}), mavlink_msg_param_value_decode);
  CHECK(std::string(m.param_id, 16) == "ABCDEFGHIJKLMNOP");
}

TEST_CASE("a change is due for storing within a second of wall time") {
  Vehicle v;
  CHECK_FALSE(v.service.save_due(5000000));
  v.set("MIS_TAKEOFF_ALT", 7.F);
  CHECK(v.service.save_due(1001000));
  v.service.save(v.params);
  CHECK_FALSE(v.service.save_due(5000000));
  v.outbox.begin(1, 0);
  v.service.stored(false, 5000000, v.outbox);
  CHECK(v.service.save_due(6000000));  // tried again
}

TEST_CASE("what was changed comes back, what was not follows the defaults") {
  Vehicle v;
  v.set("MIS_TAKEOFF_ALT", 7.F);
  const StorageRequest request = v.service.save(v.params);
  Params other_defaults;
  other_defaults.return_altitude = 12.F;
  Params loaded;
  CHECK(ParamService(other_defaults).load(request.bytes, request.size, loaded) == ParamLoad::kLoaded);
  CHECK(loaded.takeoff_altitude == 7.F);
  CHECK(loaded.return_altitude == 12.F);
  CHECK(ParamService().load(nullptr, 0, loaded) == ParamLoad::kLoaded);
}

TEST_CASE("a damaged image means defaults") {
  Vehicle v;
  v.set("MIS_TAKEOFF_ALT", 7.F);
  const StorageRequest request = v.service.save(v.params);
  for (std::size_t i = 0; i < request.size; ++i) {
    std::vector<std::uint8_t> bytes(request.bytes, request.bytes + request.size);
    bytes[i] ^= 0x40U;
    Params loaded;
    CHECK(v.service.load(bytes.data(), bytes.size(), loaded) == ParamLoad::kDamaged);
    CHECK(loaded.takeoff_altitude == 2.5F);
  }
  Params loaded;
  CHECK(v.service.load(request.bytes, request.size - 1, loaded) == ParamLoad::kDamaged);
}

TEST_CASE("reset brings defaults back but leaves what is read-only") {
  Vehicle v;
  v.params.takeoff_altitude = 9.F;
  v.params.simulation_speed = 4.F;
  v.service.reset(v.params, 0);
  CHECK(v.params.takeoff_altitude == 2.5F);
  CHECK(v.params.simulation_speed == 4.F);
}
