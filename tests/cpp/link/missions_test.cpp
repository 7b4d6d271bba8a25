// Mission transfer as clients meet it: lost, late, repeated, foreign and bad messages.
#include "link/missions.hpp"

#include <cstring>
#include <limits>
#include <memory>

#include "client.hpp"

using namespace halfroll;
using namespace halfroll::link;
using R = MissionResult;

namespace {

MissionItem waypoint(int n) {
  MissionItem item;
  item.command = n == 0 ? cmd::kTakeoff : cmd::kWaypoint;
  item.frame = kFrameRelativeInt;
  item.x = 473977420 + n;
  item.y = 85455940;
  item.z = 10.F;
  item.p[3] = std::numeric_limits<float>::quiet_NaN();
  return item;
}

/// A vehicle with nothing but a mission service, and clients around it.
struct Vehicle {
  std::unique_ptr<MissionService> service = std::make_unique<MissionService>();
  MissionSituation now;
  Outbox outbox;
  Header gcs = client::header(1, 2), other = client::header(0, 1);
  std::vector<std::uint8_t> disk;

  template <class M>
  std::vector<TxFrame> send(const M& message, const Header& from) {
    outbox.begin(1, now.t_us);
    service->receive(message, from, now, outbox);
    return client::frames(outbox);
  }
  std::vector<TxFrame> wait(std::uint64_t us) {
    std::vector<TxFrame> all;
    for (const std::uint64_t end = now.t_us + us; now.t_us < end;) {
      now.t_us += 1000;
      outbox.begin(1, now.t_us);
      service->step(now, outbox);
      for (const TxFrame& frame : client::frames(outbox)) all.push_back(frame);
    }
    return all;
  }
  /// What the shell does between calls.
  std::vector<TxFrame> write(bool ok = true) {
    const StorageRequest request = service->take_storage();
    outbox.begin(1, now.t_us);
    if (request.slot == StorageSlot::kNone) return {};
    if (ok) disk.assign(request.bytes, request.bytes + request.size);
    service->stored(ok, now, outbox);
    return client::frames(outbox);
  }
  MissionItemMessage item(int seq) const {
    MissionItemMessage m;
    m.seq = static_cast<std::uint16_t>(seq);
    m.item = waypoint(seq);
    return m;
  }
  std::vector<TxFrame> upload(int count, const Header& from) {
    send(MissionCount{{}, static_cast<std::uint16_t>(count), 0, 0}, from);
    for (int i = 0; i < count; ++i) send(item(i), from);
    wait(400000);  // a long mission is checked and named in pieces, 2000 items in 313 ms
    return write();
  }
};

bool is_request(const TxFrame& frame, int seq) {
  const auto message = client::read(frame);
  return message.msgid == MAVLINK_MSG_ID_MISSION_REQUEST_INT &&
         mavlink_msg_mission_request_int_get_seq(&message) == seq;
}
bool is_ack(const TxFrame& frame, R result, const Header& to, int type = 0) {
  const auto message = client::read(frame);
  if (message.msgid != MAVLINK_MSG_ID_MISSION_ACK || !(frame.to == to.from)) return false;
  const auto ack = client::read(frame, mavlink_msg_mission_ack_decode);
  return ack.type == static_cast<int>(result) && ack.mission_type == type && ack.target_system == to.sender.system &&
         ack.target_component == to.sender.component;
}

}  // namespace

TEST_CASE("an upload asks for each item once, writes, and acknowledges once with the mission's id") {
  Vehicle v;
  auto replies = v.send(MissionCount{{}, 3, 0, 0}, v.gcs);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(replies.size() == 1);
    CHECK(is_request(replies[0], i));
    CHECK(replies[0].to == v.gcs.from);
    CHECK(v.service->count() == 0);
    replies = v.send(v.item(i), v.gcs);
  }
  CHECK(replies.empty());  // not before it is on disk
  replies = v.write();
  REQUIRE(replies.size() == 1);
  CHECK(is_ack(replies[0], R::kAccepted, v.gcs));
  CHECK(+client::read(replies[0], mavlink_msg_mission_ack_decode).opaque_id == v.service->id());
  CHECK(v.service->count() == 3);
  CHECK(v.service->items()[2] == waypoint(2));
  CHECK(v.send(v.item(2), v.gcs).empty());
  CHECK(v.wait(10000000).empty());
}

TEST_CASE("a lost request is sent again after 250 ms") {
  Vehicle v;
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  CHECK(v.wait(249000).empty());
  const auto again = v.wait(2000);
  REQUIRE(again.size() == 1);
  CHECK(is_request(again[0], 0));
}

TEST_CASE("five silent seconds end the upload and keep the old mission") {
  Vehicle v;
  v.upload(2, v.gcs);
  const std::uint32_t id = v.service->id();
  v.send(MissionCount{{}, 3, 0, 0}, v.gcs);
  v.send(v.item(0), v.gcs);
  const auto sent = v.wait(6000000);
  int acks = 0, requests = 0, texts = 0;
  for (const TxFrame& frame : sent) {
    acks += is_ack(frame, R::kOperationCancelled, v.gcs) ? 1 : 0;
    requests += is_request(frame, 1) ? 1 : 0;
    texts += client::read(frame).msgid == MAVLINK_MSG_ID_STATUSTEXT ? 1 : 0;
  }
  CHECK(acks == 1);
  CHECK(requests == 19);  // each 250 ms, none when time is up
  CHECK(texts == kLinkCount);
  CHECK(v.service->id() == id);
  CHECK_FALSE(v.service->uploading());
}

TEST_CASE("a vehicle that lives four times as fast waits four times as long") {
  Vehicle v;
  v.now.time_factor = 4.F;
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  CHECK(v.wait(999000).empty());
  CHECK(v.wait(2000).size() == 1);
}

TEST_CASE("a repeated COUNT starts again, however often") {
  Vehicle v;
  for (int n = 0; n < 20; ++n) {
    const auto replies = v.send(MissionCount{{}, 3, 0, 0}, v.gcs);
    REQUIRE(replies.size() == 1);
    CHECK(is_request(replies[0], 0));
    v.send(v.item(0), v.gcs);
  }
  CHECK(is_ack(v.upload(1, v.gcs).at(0), R::kAccepted, v.gcs));
}

TEST_CASE("a second client is refused and the first does not notice") {
  Vehicle v;
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  CHECK(is_ack(v.send(MissionCount{{}, 1, 0, 0}, v.other).at(0), R::kDenied, v.other));
  CHECK(is_ack(v.send(MissionClearAll{}, v.other).at(0), R::kDenied, v.other));
  CHECK(is_ack(v.send(MissionWritePartial{0, 0, 0}, v.other).at(0), R::kDenied, v.other));
  CHECK(v.send(v.item(0), v.other).empty());
  CHECK(v.send(MissionAck{{}, R::kOperationCancelled, 0, 0}, v.other).empty());
  CHECK(is_request(v.send(v.item(0), v.gcs).at(0), 1));
}

TEST_CASE("stray items are ignored in silence") {
  Vehicle v;
  CHECK(v.send(v.item(0), v.gcs).empty());
  v.send(MissionCount{{}, 3, 0, 0}, v.gcs);
  v.send(v.item(0), v.gcs);
  CHECK(v.send(v.item(0), v.gcs).empty());
  CHECK(v.send(v.item(2), v.gcs).empty());
  MissionItemMessage fence = v.item(1);
  fence.type = kTypeFence;
  CHECK(v.send(fence, v.gcs).empty());
  CHECK(is_request(v.send(v.item(1), v.gcs).at(0), 2));
}

TEST_CASE("a bad item ends the upload with its code and keeps the old mission") {
  Vehicle v;
  v.upload(2, v.gcs);
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  MissionItemMessage bad = v.item(0);
  bad.item.command = 9999;
  CHECK(is_ack(v.send(bad, v.gcs).at(0), R::kUnsupported, v.gcs));
  CHECK(v.send(v.item(0), v.gcs).empty());
  CHECK(v.service->count() == 2);
}

TEST_CASE("faults of the whole list are found at its end") {
  Vehicle v;
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  v.send(v.item(0), v.gcs);
  MissionItemMessage jump = v.item(1);
  jump.item = {};
  jump.item.command = cmd::kJump;
  jump.item.frame = kFrameMission;
  jump.item.p = {7.F, 1.F, 0.F, 0.F};
  CHECK(is_ack(v.send(jump, v.gcs).at(0), R::kInvalidParam1, v.gcs));
  CHECK(v.write().empty());
  CHECK(v.service->count() == 0);
}

TEST_CASE("a download returns every bit, also during somebody's upload") {
  Vehicle v;
  v.upload(4, v.gcs);
  v.service->set_current(2);
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  const auto count = client::read(v.send(MissionRequestList{}, v.other).at(0), mavlink_msg_mission_count_decode);
  CHECK(+count.count == 4);
  CHECK(+count.opaque_id == v.service->id());
  for (int i = 0; i < 4; ++i) {
    const auto reply = v.send(MissionRequest{{}, static_cast<std::uint16_t>(i), 0, true}, v.other).at(0);
    const auto m = client::read(reply, mavlink_msg_mission_item_int_decode);
    Parser parser;
    const auto got = client::parse(parser, client::Bytes(reply.bytes.begin(), reply.bytes.begin() + reply.size));
    CHECK(std::get_if<MissionItemMessage>(&got.at(0).message)->item == waypoint(i));
    CHECK(+m.current == (i == 2 ? 1 : 0));
    CHECK(+m.target_system == 255);
    CHECK(reply.to == v.other.from);
  }
  CHECK(+client::read(v.send(MissionRequest{{}, 1, 0, false}, v.other).at(0)).msgid == MAVLINK_MSG_ID_MISSION_ITEM);
  CHECK(is_ack(v.send(MissionRequest{{}, 4, 0, true}, v.other).at(0), R::kInvalidSequence, v.other));
  CHECK(is_ack(v.send(MissionRequestPartial{}, v.other).at(0), R::kUnsupported, v.other));
  CHECK(v.send(MissionAck{}, v.other).empty());
}

TEST_CASE("a mission that cannot be written is not taken") {
  Vehicle v;
  v.upload(2, v.gcs);
  const std::uint32_t id = v.service->id(), revision = v.service->revision();
  v.send(MissionCount{{}, 1, 0, 0}, v.gcs);
  v.send(v.item(0), v.gcs);
  const auto replies = v.write(false);
  CHECK(is_ack(replies.back(), R::kError, v.gcs));
  CHECK(v.service->id() == id);
  CHECK(v.service->revision() == revision);
  CHECK_FALSE(v.service->uploading());
}

TEST_CASE("a part is replaced and the rest stays") {
  Vehicle v;
  v.upload(4, v.gcs);
  CHECK(is_request(v.send(MissionWritePartial{1, 2, 0}, v.gcs).at(0), 1));
  MissionItemMessage changed = v.item(1);
  changed.item.z = 33.F;
  CHECK(is_request(v.send(changed, v.gcs).at(0), 2));
  v.send(v.item(2), v.gcs);
  CHECK(is_ack(v.write().at(0), R::kAccepted, v.gcs));
  CHECK(v.service->count() == 4);
  CHECK(v.service->items()[1].z == 33.F);
  CHECK(v.service->items()[3] == waypoint(3));
  for (const MissionWritePartial bad : {MissionWritePartial{2, 1, 0}, {-1, 1, 0}, {0, 4, 0}}) {
    CHECK(is_ack(v.send(bad, v.gcs).at(0), R::kInvalidSequence, v.gcs));
  }
}

TEST_CASE("nothing is written while the mission is being flown") {
  Vehicle v;
  v.upload(2, v.gcs);
  v.now.flying_it = true;
  CHECK(is_ack(v.send(MissionCount{{}, 1, 0, 0}, v.gcs).at(0), R::kDenied, v.gcs));
  CHECK(is_ack(v.send(MissionClearAll{}, v.gcs).at(0), R::kDenied, v.gcs));
  CHECK(is_ack(v.send(MissionWritePartial{0, 0, 0}, v.gcs).at(0), R::kDenied, v.gcs));
  CHECK(v.service->count() == 2);
}

TEST_CASE("clearing empties the store, and an empty store is cleared at once") {
  Vehicle v;
  v.upload(2, v.gcs);
  CHECK(v.send(MissionClearAll{kTypeAll}, v.gcs).empty());
  CHECK(is_ack(v.write().at(0), R::kAccepted, v.gcs, kTypeAll));
  CHECK(v.service->count() == 0);
  CHECK(v.service->id() == 0);
  CHECK(is_ack(v.send(MissionClearAll{}, v.gcs).at(0), R::kAccepted, v.gcs));
  CHECK(is_ack(v.send(MissionCount{{}, 0, 0, 0}, v.gcs).at(0), R::kAccepted, v.gcs));
}

TEST_CASE("fence and rally are always empty") {
  Vehicle v;
  for (const std::uint8_t type : {kTypeFence, kTypeRally}) {
    const auto count = client::read(v.send(MissionRequestList{type}, v.gcs).at(0), mavlink_msg_mission_count_decode);
    CHECK(+count.count == 0);
    CHECK(+count.mission_type == type);
    CHECK(is_ack(v.send(MissionCount{{}, 0, type, 0}, v.gcs).at(0), R::kAccepted, v.gcs, type));
    CHECK(is_ack(v.send(MissionCount{{}, 2, type, 0}, v.gcs).at(0), R::kUnsupported, v.gcs, type));
    CHECK(is_ack(v.send(MissionClearAll{type}, v.gcs).at(0), R::kAccepted, v.gcs, type));
  }
  for (const std::uint8_t type : {std::uint8_t{3}, kTypeAll}) {
    CHECK(is_ack(v.send(MissionRequestList{type}, v.gcs).at(0), R::kUnsupported, v.gcs, type));
    CHECK(is_ack(v.send(MissionCount{{}, 2, type, 0}, v.gcs).at(0), R::kUnsupported, v.gcs, type));
  }
}

TEST_CASE("two thousand items fit and one more does not") {
  Vehicle v;
  CHECK(is_ack(v.send(MissionCount{{}, 2001, 0, 0}, v.gcs).at(0), R::kNoSpace, v.gcs));
  CHECK(is_ack(v.upload(2000, v.gcs).at(0), R::kAccepted, v.gcs));
  CHECK(v.service->count() == 2000);
}

TEST_CASE("the client may cancel") {
  Vehicle v;
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  CHECK(v.send(MissionAck{{}, R::kOperationCancelled, 0, 0}, v.gcs).empty());
  CHECK_FALSE(v.service->uploading());
}

TEST_CASE("old guided items are unsupported") {
  Vehicle v;
  MissionItemMessage guided = v.item(0);
  guided.current = 2;
  CHECK(is_ack(v.send(guided, v.gcs).at(0), R::kUnsupported, v.gcs));
}

TEST_CASE("a mission survives a restart, and a damaged image is no mission") {
  Vehicle v;
  v.upload(5, v.gcs);
  MissionService fresh;
  REQUIRE(fresh.load(v.disk.data(), v.disk.size()));
  CHECK(fresh.count() == 5);
  CHECK(fresh.id() == v.service->id());
  CHECK(fresh.items()[4] == waypoint(4));
  CHECK(fresh.load(nullptr, 0));
  for (std::size_t i = 0; i < v.disk.size(); ++i) {
    std::vector<std::uint8_t> damaged = v.disk;
    damaged[i] ^= 1U;
    MissionService none;
    CHECK_FALSE(none.load(damaged.data(), damaged.size()));
    CHECK(none.count() == 0);
  }
  CHECK_FALSE(MissionService().load(v.disk.data(), v.disk.size() - 1));
}

TEST_CASE("a copy is equal until something happens to one of them") {
  Vehicle v;
  v.upload(2, v.gcs);
  const auto copy = std::make_unique<MissionService>(*v.service);
  CHECK(*copy == *v.service);
  v.send(MissionCount{{}, 2, 0, 0}, v.gcs);
  CHECK_FALSE(*copy == *v.service);
}
