// Received frames against the generated encoder, sent frames against the generated decoder.
#include "link/codec.hpp"

#include <cmath>
#include <limits>

#include "client.hpp"
#include "link/echo.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

client::Bytes command_long(std::uint16_t command = 400, bool version1 = false) {
  mavlink_command_long_t m = {};
  m.target_system = 1;
  m.target_component = 1;
  m.command = command;
  m.param1 = 1.F;
  m.param7 = std::numeric_limits<float>::quiet_NaN();
  return client::frame(m, mavlink_msg_command_long_encode_status, version1);
}

MissionItem odd_item() {
  MissionItem item;
  item.p = {std::numeric_limits<float>::quiet_NaN(), -0.F, 1.5F, 1e-30F};
  item.x = -1;
  item.y = INT32_MAX;
  item.z = std::numeric_limits<float>::quiet_NaN();
  item.command = 31000;
  item.frame = 6;
  item.autocontinue = 7;
  return item;
}

}  // namespace

TEST_CASE("a command arrives with its numbers, sender, target and endpoint") {
  Parser parser;
  const auto got = client::parse(parser, command_long(), {1, 3});
  REQUIRE(got.size() == 1);
  CHECK(got[0].header == Header{{255, 190}, {1, 1}, {1, 3}});
  const auto* command = std::get_if<Command>(&got[0].message);
  REQUIRE(command != nullptr);
  CHECK(command->command == 400);
  CHECK(command->p[0] == 1.F);
  CHECK(std::isnan(command->p[6]));
}

TEST_CASE("MAVLink 1 frames are understood") {
  Parser parser;
  CHECK(client::parse(parser, command_long(400, true)).size() == 1);
}

TEST_CASE("frames may be split and joined in any way") {
  Parser parser;
  client::Bytes two = command_long();
  const client::Bytes second = command_long(511);
  two.insert(two.end(), second.begin(), second.end());
  std::size_t count = 0;
  for (const std::uint8_t byte : two) count += client::parse(parser, {byte}).size();
  CHECK(count == 2);
  CHECK(client::parse(parser, two).size() == 2);
}

TEST_CASE("any single damaged byte loses that frame and never the next one") {
  const client::Bytes good = command_long();
  for (std::size_t i = 1; i < good.size(); ++i) {
    Parser parser;
    client::Bytes bytes = good;
    bytes[i] ^= 0x10U;
    for (int n = 0; n < 8; ++n) bytes.insert(bytes.end(), good.begin(), good.end());  // enough to end any false length
    CHECK(client::parse(parser, bytes).size() == 8);
  }
}

TEST_CASE("unknown messages, empty payloads and short MAVLink 1 payloads are dropped") {
  Parser parser;
  client::Bytes empty = {0xFD, 0, 0, 0, 0, 255, 190, 0, 0, 0};
  std::uint16_t crc = crc_calculate(&empty[1], 9);
  crc_accumulate(50, &crc);  // HEARTBEAT
  empty.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  empty.push_back(static_cast<std::uint8_t>(crc >> 8U));
  CHECK(client::parse(parser, empty).empty());

  client::Bytes shortened = {0xFE, 2, 0, 255, 190, 43, 1, 1};  // MISSION_REQUEST_LIST wants 2: good
  client::Bytes too_short = {0xFE, 1, 0, 255, 190, 43, 1};
  for (client::Bytes* bytes : {&shortened, &too_short}) {
    std::uint16_t sum = crc_calculate(bytes->data() + 1, static_cast<std::uint16_t>(bytes->size() - 1));
    crc_accumulate(132, &sum);
    bytes->push_back(static_cast<std::uint8_t>(sum & 0xFFU));
    bytes->push_back(static_cast<std::uint8_t>(sum >> 8U));
  }
  CHECK(client::parse(parser, too_short).empty());
  CHECK(client::parse(parser, shortened).size() == 1);
}

TEST_CASE("trailing zeros that MAVLink 2 leaves out come back as zeros") {
  mavlink_mission_count_t m = {};
  m.target_system = 1;
  m.target_component = 1;
  m.count = 5;
  const client::Bytes bytes = client::frame(m, mavlink_msg_mission_count_encode_status);
  CHECK(bytes.size() < 12 + 9);
  Parser parser;
  const auto got = client::parse(parser, bytes);
  REQUIRE(got.size() == 1);
  const auto* count = std::get_if<MissionCount>(&got[0].message);
  REQUIRE(count != nullptr);
  CHECK(count->count == 5);
  CHECK(count->type == kTypeMission);
  CHECK(count->opaque_id == 0);
}

TEST_CASE("a signed frame is taken, its signature skipped") {
  client::Bytes bytes = command_long();
  bytes[2] = MAVLINK_IFLAG_SIGNED;
  const auto payload_end = bytes.size() - 2;
  std::uint16_t crc = crc_calculate(&bytes[1], static_cast<std::uint16_t>(payload_end - 1));
  crc_accumulate(152, &crc);  // COMMAND_LONG
  bytes[payload_end] = static_cast<std::uint8_t>(crc & 0xFFU);
  bytes[payload_end + 1] = static_cast<std::uint8_t>(crc >> 8U);
  bytes.insert(bytes.end(), 13, 0xFD);
  Parser parser;
  CHECK(client::parse(parser, bytes).size() == 1);
}

TEST_CASE("a mission item comes and goes with every bit, NaN and minus zero included") {
  MissionItemMessage out;
  out.item = odd_item();
  out.seq = 1999;
  TxFrame frame = encode(out, Envelope{9, 77});
  const auto m = client::read(frame, mavlink_msg_mission_item_int_decode);
  CHECK(+m.seq == 1999);
  CHECK(+m.command == 31000);
  CHECK(+m.y == INT32_MAX);
  CHECK(std::isnan(m.param1));
  CHECK(+client::read(frame).sysid == 9);
  CHECK(+client::read(frame).seq == 77);
  Parser parser;
  const auto got = client::parse(parser, client::Bytes(frame.bytes.begin(), frame.bytes.begin() + frame.size));
  REQUIRE(got.size() == 1);
  const auto* back = std::get_if<MissionItemMessage>(&got[0].message);
  REQUIRE(back != nullptr);
  CHECK(back->item == odd_item());
}

TEST_CASE("the older MISSION_ITEM carries degrees") {
  mavlink_mission_item_t m = {};
  m.command = 16;
  m.frame = 3;
  m.x = 47.5F;
  m.y = -8.25F;
  Parser parser;
  const auto got = client::parse(parser, client::frame(m, mavlink_msg_mission_item_encode_status));
  REQUIRE(got.size() == 1);
  const auto* item = std::get_if<MissionItemMessage>(&got[0].message);
  REQUIRE(item != nullptr);
  CHECK_FALSE(item->as_int);
  CHECK(item->item.x == 475000000);
  CHECK(item->item.y == -82500000);
  const auto back = client::read(encode(*item, Envelope{}), mavlink_msg_mission_item_decode);
  CHECK(+back.x == 47.5F);
  CHECK(+back.y == -8.25F);
}

TEST_CASE("an attitude setpoint to the right is a negative roll about forward-left-up's left-hand side") {
  mavlink_set_attitude_target_t m = {};
  m.time_boot_ms = 12;
  m.type_mask = 7;
  m.q[0] = std::cos(0.1F);
  m.q[2] = std::sin(0.1F);  // pitch up on the wire
  m.body_yaw_rate = 2.F;    // clockwise on the wire
  m.thrust = -0.5F;
  Parser parser;
  const auto got = client::parse(parser, client::frame(m, mavlink_msg_set_attitude_target_encode_status));
  REQUIRE(got.size() == 1);
  const auto* in = std::get_if<SetAttitudeTarget>(&got[0].message);
  REQUIRE(in != nullptr);
  const Vec3 nose = Eigen::Quaternionf(in->q_WD.w, in->q_WD.x, in->q_WD.y, in->q_WD.z) * Vec3::UnitX();
  CHECK(nose.z() > 0.F);          // up, in W
  CHECK(in->w_WD_D.z() == -2.F);  // counter-clockwise positive
  CHECK(in->thrust == -0.5F);
  CHECK(in->type_mask == 7);
}

namespace {

/// Of the three messages that carry a pose: 1 m north, 2 m east, 3 m down, the nose a quarter turn clockwise from
/// north.
ExternalPose pose_of(const client::Bytes& bytes) {
  Parser parser;
  const auto got = client::parse(parser, bytes);
  REQUIRE(got.size() == 1);
  const auto* in = std::get_if<ExternalPose>(&got[0].message);
  REQUIRE(in != nullptr);
  CHECK(in->pose.t_us == 123456789);
  CHECK(in->pose.p_WB == Vec3{1.F, -2.F, -3.F});  // north, west, up
  const Vec3 nose =
      Eigen::Quaternionf(in->pose.q_WB.w, in->pose.q_WB.x, in->pose.q_WB.y, in->pose.q_WB.z) * Vec3::UnitX();
  CHECK((nose - Vec3{0.F, -1.F, 0.F}).norm() < 1e-5F);  // east
  return *in;
}

void fill_covariance(float (&covariance)[21]) {
  covariance[0] = 4e-6F, covariance[6] = 9e-6F, covariance[11] = 1e-6F;
  covariance[15] = 1e-4F, covariance[18] = 1e-4F, covariance[20] = 4e-4F;
}

}  // namespace

TEST_CASE("the three messages that carry a pose say the same in north-west-up, with their deviations") {
  const float half = std::sqrt(0.5F);
  mavlink_odometry_t odometry = {};
  odometry.time_usec = 123456789;
  odometry.frame_id = MAV_FRAME_LOCAL_NED;
  odometry.child_frame_id = MAV_FRAME_BODY_FRD;
  odometry.x = 1.F, odometry.y = 2.F, odometry.z = 3.F;
  odometry.q[0] = odometry.q[3] = half;
  odometry.reset_counter = 4;
  fill_covariance(odometry.pose_covariance);
  const ExternalPose a = pose_of(client::frame(odometry, mavlink_msg_odometry_encode_status));
  CHECK(a.frame == MAV_FRAME_LOCAL_NED);
  CHECK(a.pose.resets == 4);
  CHECK((a.pose.position_deviation - Vec3{2e-3F, 3e-3F, 1e-3F}).norm() < 1e-8F);
  CHECK((a.pose.attitude_deviation - Vec3{1e-2F, 1e-2F, 2e-2F}).norm() < 1e-7F);

  mavlink_att_pos_mocap_t mocap = {};
  mocap.time_usec = 123456789;
  mocap.x = 1.F, mocap.y = 2.F, mocap.z = 3.F;
  mocap.q[0] = mocap.q[3] = half;
  mocap.covariance[0] = std::numeric_limits<float>::quiet_NaN();
  const ExternalPose b = pose_of(client::frame(mocap, mavlink_msg_att_pos_mocap_encode_status));
  CHECK(b.pose.position_deviation == Vec3::Zero());  // not said
  CHECK(b.pose.attitude_deviation == Vec3::Zero());

  mavlink_vision_position_estimate_t vision = {};
  vision.usec = 123456789;
  vision.x = 1.F, vision.y = 2.F, vision.z = 3.F;
  vision.yaw = 1.57079633F;
  fill_covariance(vision.covariance);
  const ExternalPose c = pose_of(client::frame(vision, mavlink_msg_vision_position_estimate_encode_status));
  CHECK((c.pose.position_deviation - a.pose.position_deviation).norm() == 0.F);
}

TEST_CASE("only what is meant for us is for us") {
  const auto to = [](std::uint8_t system, std::uint8_t component) {
    return Header{{255, 190}, {system, component}, {}};
  };
  CHECK(is_for_us(to(0, 0), 1));
  CHECK(is_for_us(to(1, 0), 1));
  CHECK(is_for_us(to(1, 1), 1));
  CHECK_FALSE(is_for_us(to(2, 1), 1));
  CHECK_FALSE(is_for_us(to(1, 191), 1));
  CHECK_FALSE(is_for_us(Header{{1, 1}, {0, 0}, {}}, 1));
  CHECK(is_for_us(Header{{1, 191}, {1, 1}, {}}, 1));
}

TEST_CASE("frames are numbered per link without gaps") {
  Outbox outbox;
  outbox.begin(1, 0);
  outbox.send({0, 2}, Timesync{1, 2});
  outbox.send(kToAll, Timesync{1, 2});
  outbox.send(everyone_on(1), Timesync{1, 2});
  std::array<std::vector<int>, kLinkCount> numbers;
  for (const TxFrame& frame : client::frames(outbox)) numbers[frame.to.link].push_back(client::read(frame).seq);
  CHECK(numbers[0] == std::vector<int>{0, 1});
  CHECK(numbers[1] == std::vector<int>{0, 1});
  CHECK(numbers[2] == std::vector<int>{0});
}

TEST_CASE("a full outbox counts what it cannot take") {
  Outbox outbox;
  outbox.begin(1, 0);
  for (std::size_t i = 0; i < Outbox::kCapacity + 5; ++i) outbox.send({0, 0}, Timesync{1, 2});
  CHECK(outbox.size() == Outbox::kCapacity);
  CHECK(outbox.overflows() == 5);
}

TEST_CASE("the same text is said once a second, and ten texts a second in all") {
  Outbox outbox;
  int said = 0;
  for (std::uint64_t t_us = 0; t_us < 3000000; t_us += 1000) {
    outbox.begin(1, t_us);
    outbox.say(Severity::kWarning, "Mission: the same");
    said += static_cast<int>(client::frames(outbox, MAVLINK_MSG_ID_STATUSTEXT).size());
  }
  CHECK(said == 3 * kLinkCount);
  Outbox other;
  other.begin(1, 0);
  for (char c = 'a'; c <= 'z'; ++c) other.say(Severity::kInfo, (std::string("Mode: ") + c).c_str());
  CHECK(other.size() == 10 * kLinkCount);
}

TEST_CASE("a long text is cut at 50 characters") {
  const std::string words(60, 'x');
  const auto m =
      client::read(encode(StatusText{Severity::kInfo, words.c_str()}, Envelope{}), mavlink_msg_statustext_decode);
  CHECK(std::string(m.text, sizeof m.text) == std::string(50, 'x'));
}

TEST_CASE("TIMESYNC is answered with our time and the asker's stamp, never with zero") {
  Outbox outbox;
  outbox.begin(1, 0);
  answer(Timesync{0, 1234}, client::header(1, 4), 0, outbox);
  answer(Timesync{55, 1234}, client::header(1, 4), 0, outbox);  // an answer: left alone
  REQUIRE(outbox.size() == 1);
  const auto m = client::read(outbox.frames()[0], mavlink_msg_timesync_decode);
  CHECK(+m.tc1 != 0);
  CHECK(+m.ts1 == 1234);
  CHECK(outbox.frames()[0].to == Endpoint{1, 4});
}

TEST_CASE("PING to everybody is answered, an answer is not") {
  Outbox outbox;
  outbox.begin(1, 0);
  answer(Ping{{0, 0}, 99, 7}, client::header(), outbox);
  answer(Ping{{1, 1}, 99, 7}, client::header(), outbox);
  REQUIRE(outbox.size() == 1);
  const auto m = client::read(outbox.frames()[0], mavlink_msg_ping_decode);
  CHECK(+m.target_system == 255);
  CHECK(+m.target_component == 190);
  CHECK(+m.seq == 7);
  CHECK(+m.time_usec == 99);
}

TEST_CASE("file transfer is refused in a way clients understand") {
  FileTransfer asked;
  asked.payload[0] = 255;
  asked.payload[2] = 9;
  asked.payload[3] = 4;  // OpenFileRO
  Outbox outbox;
  outbox.begin(1, 0);
  answer(asked, client::header(), outbox);
  asked.payload[3] = 2;  // ResetSessions
  answer(asked, client::header(), outbox);
  REQUIRE(outbox.size() == 2);
  const auto refused = client::read(outbox.frames()[0], mavlink_msg_file_transfer_protocol_decode);
  CHECK(+refused.payload[0] == 0);  // sequence 256
  CHECK(+refused.payload[1] == 1);
  CHECK(+refused.payload[2] == 9);
  CHECK(+refused.payload[3] == 129);
  CHECK(+refused.payload[4] == 1);
  CHECK(+refused.payload[5] == 4);
  CHECK(+refused.payload[12] == 10);
  CHECK(client::read(outbox.frames()[1], mavlink_msg_file_transfer_protocol_decode).payload[3] == 128);
}
