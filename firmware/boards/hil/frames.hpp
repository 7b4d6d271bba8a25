// What host and board tell each other when the world is simulated: the frame format, compiled by both ends.
//
// A frame is "hr", kind (1 byte), version (1), payload size (4), payload, CRC-32 of all before it but "hr". Every frame
// of the host is answered by one of the board; a board that has (re)started says kHello by itself.
#pragma once
#include "boards/board.hpp"
#include "boards/hil/byte_stream.hpp"
#include "link/checksum.hpp"

namespace halfroll {  // found by argument: fields must stand beside their struct

namespace hil {
inline constexpr std::uint8_t kVersion = 1;
inline constexpr std::array<std::uint8_t, 2> kSync = {'h', 'r'};
inline constexpr std::size_t kHead = 8, kTail = 4;
inline constexpr std::size_t kLongestRequest = 12 * 1024;  // payload of the host's; the board's have any length
inline constexpr std::size_t kMostDatagrams = 17;          // of one request

enum class Kind : std::uint8_t {
  kStart = 1,  // host: Start;                board: Params as in use
  kStep,       // host: Turn with sensors;    board: rotors, Shown, frames
  kService,    // host: Turn without;         board: Shown, frames
  kEnd,        // host: nothing;              board: Totals, and it ends
  kHello       // board alone: it has started and waits for kStart
};

/// What a step leaves to see, beside rotor commands and frames.
struct Shown {
  std::uint64_t t_us = 0;
  std::uint8_t mode = 0;
  bool armed = false, time_answered = false, result_pending = false, shut_down = false, reboot = false;
  std::uint32_t ground_frames = 0;
  Estimate estimate;
  Reference reference;
  std::uint32_t state_checksum = 0;
  std::uint32_t instructions = 0;  // of the step; 0: this board does not count them
};

/// What a board has measured since it started.
struct Totals {
  std::uint32_t stack_bytes = 0, late_steps = 0;
};

template <class X>
auto fields(X& x, Tag<Shown>) {
  return std::tie(x.t_us, x.mode, x.armed, x.time_answered, x.result_pending, x.shut_down, x.reboot, x.ground_frames,
                  x.estimate, x.reference, x.state_checksum, x.instructions);
}
template <class X>
auto fields(X& x, Tag<Totals>) {
  return std::tie(x.stack_bytes, x.late_steps);
}
template <class X>
auto fields(X& x, Tag<Quat>) {
  return std::tie(x.w, x.x, x.y, x.z);
}
template <class X>
auto fields(X& x, Tag<Imu>) {
  return std::tie(x.w_WB_B, x.specific_force_B);
}
template <class X>
auto fields(X& x, Tag<PoseFix>) {
  return std::tie(x.t_us, x.p_WB, x.q_WB, x.position_deviation, x.attitude_deviation, x.resets);
}
template <class X>
auto fields(X& x, Tag<GpsFix>) {
  return std::tie(x.t_us, x.p_WB, x.v_WB, x.horizontal_deviation, x.vertical_deviation, x.speed_deviation);
}
template <class X>
auto fields(X& x, Tag<BarometerSample>) {
  return std::tie(x.t_us, x.height);
}
template <class X>
auto fields(X& x, Tag<MagnetometerSample>) {
  return std::tie(x.t_us, x.field_B);
}
template <class X>
auto fields(X& x, Tag<Measurements>) {
  return std::tie(x.imu, x.pose, x.gps, x.barometer, x.magnetometer);
}
template <class X>
auto fields(X& x, Tag<Battery>) {
  return std::tie(x.voltage, x.state_of_charge);
}
template <class X>
auto fields(X& x, Tag<RotorCommands>) {
  return std::tie(x.thrust);
}
template <class X>
auto fields(X& x, Tag<Estimate>) {
  return std::tie(x.q_WB, x.w_WB_B, x.p_WB, x.v_WB, x.attitude_valid, x.position_valid, x.aiding, x.resets,
                  x.attitude_deviation, x.velocity_deviation, x.position_deviation);
}
template <class X>
auto fields(X& x, Tag<Reference>) {
  return std::tie(x.q_WD, x.w_WD_D, x.dw_WD_D, x.thrust);
}
template <class X>
auto fields(X& x, Tag<Vehicle>) {
  return std::tie(x.mass, x.inertia, x.arm, x.yaw_coefficient, x.rotor_kind, x.thrust_min, x.thrust_max, x.rotor_lag,
                  x.rotor_lag_down);
}

/// Params are floats and nothing else: as one array.
template <class Io, class P>
void pass_params(Io& io, P& params) {
  for (const ParamInfo& row : kParamTable) io(params.*row.member);
}

template <class Io, class S>
void pass_start(Io& io, S& start) {
  std::int32_t lat = start.boot.origin.lat_degE7(), lon = start.boot.origin.lon_degE7(),
               alt = start.boot.origin.alt_mm();
  io(start.vehicle);
  pass_params(io, start.params);
  io(lat, lon, alt, start.boot.px4_identity, start.boot.unix_us_at_wall_0, start.boot.signing_policies,
     start.boot.signing_key);
  if constexpr (!std::is_const_v<S>) start.boot.origin = {lat, lon, alt};
}

struct Counter {
  std::size_t size = 0;
  void take(const std::uint8_t*, std::size_t more) { size += more; }
};
template <class Sink>
struct Summing {
  Sink& sink;
  std::uint32_t crc = 0;
  void take(const std::uint8_t* bytes, std::size_t size) {
    crc = link::crc32(bytes, size, crc);
    sink.take(bytes, size);
  }
};

/// One frame into the sink; body(writer) writes the payload, and is asked twice: the size comes first.
template <class Sink, class Body>
void write_frame(Sink& sink, Kind kind, const Body& body) {
  Counter counter;
  Writer<Counter> counting(counter);
  body(counting);
  sink.take(kSync.data(), kSync.size());
  Summing<Sink> summing{sink};
  Writer<Summing<Sink>> writer(summing);
  writer(kind, kVersion, static_cast<std::uint32_t>(counter.size));
  body(writer);
  const std::uint32_t crc = summing.crc;
  Writer<Sink>{sink}(crc);
}

/// A frame's first eight bytes.
struct Head {
  Kind kind = Kind::kHello;
  std::uint32_t size = 0;
  bool good = false;
};
inline Head read_head(const std::uint8_t* bytes) {
  Head head;
  std::uint8_t version = 0;
  Reader(bytes + kSync.size(), kHead - kSync.size())(head.kind, version, head.size);
  head.good = bytes[0] == kSync[0] && bytes[1] == kSync[1] && version == kVersion;
  return head;
}
/// Whether head and payload, as they lie in memory, have the CRC that follows them.
inline bool is_whole(const std::uint8_t* frame, std::size_t payload) {
  const std::size_t end = kHead + payload;
  std::uint32_t crc = 0;
  Reader(frame + end, kTail)(crc);
  return crc == link::crc32(frame + kSync.size(), end - kSync.size());
}

template <class Sink>
void write_frames(Writer<Sink>& writer, const LinkOutputs& out) {
  writer(static_cast<std::uint16_t>(out.tx_count));
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    writer(frame.to.link, frame.to.slot, frame.size);
    writer.bytes(frame.bytes.data(), frame.size);
  }
}

template <class Sink>
void write_turn(Writer<Sink>& writer, Kind kind, const Inputs& in, bool ask_time) {
  writer(ask_time, in.link.wall_us);
  if (kind == Kind::kStep) writer(in.measured, in.battery);
  writer(static_cast<std::uint8_t>(in.link.rx_count));
  for (std::size_t i = 0; i < in.link.rx_count; ++i) {
    const link::Datagram& datagram = in.link.rx[i];
    writer(datagram.from.link, datagram.from.slot, static_cast<std::uint16_t>(datagram.size));
    writer.bytes(datagram.bytes, datagram.size);
  }
}

/// `rx` keeps the datagrams, whose bytes stay where the reader found them.
inline void read_turn(Reader& reader, Kind kind, boards::Turn& turn, std::array<link::Datagram, kMostDatagrams>& rx) {
  std::uint8_t count = 0;
  reader(turn.ask_time, turn.inputs.link.wall_us);
  if (kind == Kind::kStep) reader(turn.inputs.measured, turn.inputs.battery);
  reader(count);
  turn.inputs.link.rx = rx.data();
  turn.inputs.link.rx_count = 0;
  for (std::size_t i = 0; i < count && i < rx.size(); ++i) {
    std::uint16_t size = 0;
    reader(rx[i].from.link, rx[i].from.slot, size);
    rx[i].bytes = reader.bytes(size);
    rx[i].size = size;
    if (reader.good()) ++turn.inputs.link.rx_count;
  }
}

}  // namespace hil
}  // namespace halfroll
