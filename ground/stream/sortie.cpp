#include "stream/sortie.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "link/codec.hpp"
#include "link/wire_ids.hpp"
#include "sim/sitl/sensed.hpp"

namespace halfroll::stream {
namespace {

constexpr std::uint8_t kGroundLink = 0, kPilotLink = 1;
constexpr std::uint64_t kArmRetryUs = 500000;
// The ground station's own rules (station/following.py).
constexpr double kStartDistance = 0.05, kStartSpeed = 0.1;  // [m], [m/s]
constexpr double kSettlesWithin = 10.0;                     // [s] after the approach
constexpr double kErrorLimit = 1.0;                         // [m] from the plan, for longer than
constexpr std::uint64_t kErrorLimitUs = 100000;
constexpr float kBodyRateLargest = 40.F;  // [rad/s]: a setpoint beyond is dropped whole
constexpr std::uint32_t kMissionItemReached = 46;

link::Datagram datagram(const std::uint8_t* bytes, std::size_t size, std::uint8_t from) {
  return {{from, 0}, bytes, size};
}

std::uint32_t id_of(const link::TxFrame& frame) {
  const auto& b = frame.bytes;
  return b[7] | static_cast<std::uint32_t>(b[8]) << 8U | static_cast<std::uint32_t>(b[9]) << 16U;
}

/// The first two bytes of a payload; zeros at its end are cut off on the wire.
int first_word(const link::TxFrame& frame) {
  constexpr std::size_t kHeader = 10;
  return frame.bytes[kHeader] | (frame.bytes[1] > 1 ? frame.bytes[kHeader + 1] << 8 : 0);
}

Boot boot_from(const link::Origin& origin, const Bytes& mission) {
  Boot boot;
  boot.origin = origin;
  if (!mission.empty()) boot.mission = {link::StoredState::kSound, mission.data(), mission.size()};
  return boot;
}

}  // namespace

Sortie::Sortie(const Vehicle& vehicle, const Params& params, const sim::Plant& plant, const sim::Scenario& scenario,
               std::uint64_t seed, const link::Origin& origin, Bytes mission)
    : image_(std::move(mission)),
      model_(plant, scenario),
      world_(sim::start(model_, seed)),
      autopilot_(vehicle, params, boot_from(origin, image_)) {}

std::vector<Bytes> Sortie::service(const Bytes& bytes, int link) {
  const link::Datagram received = datagram(bytes.data(), bytes.size(), static_cast<std::uint8_t>(link));
  const LinkOutputs out = autopilot_.service(inputs(received));
  hear(out);
  std::vector<Bytes> sent;
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (frame.to.link == link) sent.emplace_back(frame.bytes.begin(), frame.bytes.begin() + frame.size);
  }
  return sent;
}

/// Storage exists only in the shells; here a write succeeds at once.
LinkInputs Sortie::inputs(const link::Datagram& received) {
  LinkInputs in;
  in.rx = &received;
  in.rx_count = received.size == 0 ? 0 : 1;
  in.wall_us = t_us();
  in.stored = {storing_, true};
  storing_ = link::StorageSlot::kNone;
  return in;
}

void Sortie::hear(const LinkOutputs& out) {
  storing_ = out.store.slot;
  if (storing_ == link::StorageSlot::kMission) stored_.assign(out.store.bytes, out.store.bytes + out.store.size);
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (frame.to.link != kGroundLink && frame.to.link != link::kAllLinks) continue;
    const std::uint32_t id = id_of(frame);
    if (id == link::msg::kHomePosition) heard_.home = true;
    if (id == kMissionItemReached) heard_.reached |= first_word(frame) == first_item_;
    if (id == link::msg::kLocalPosition) heard_at_tick_ = heard_;
  }
}

/// One millisecond, in the order of sim/sitl/simulation.cpp.
void Sortie::step() {
  const link::Datagram nothing;
  Inputs in = sitl::sensed(world_);
  in.link = inputs(nothing);
  const Outputs out = autopilot_.step(in);
  const sim::Vec3d& p = world_.body.p_WB;
  positions_.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  commands_.push_back(out.rotors.thrust);
  hear(out.link);
  sim::step(model_, world_, out.rotors);
}

bool Sortie::take_off(const std::vector<Bytes>& commands, int first_item, double patience_s) {
  const auto give_up_us = t_us() + static_cast<std::uint64_t>(1e6 * patience_s);
  first_item_ = first_item;
  std::size_t next = 0;
  std::uint64_t again_us = 0;
  while (t_us() < give_up_us && !world_.contact.crashed) {
    step();
    if (!at_tick()) continue;
    if (!autopilot_.armed() && heard_at_tick_.home && t_us() >= again_us) {
      for (; next < commands.size(); ++next) service(commands[next], kPilotLink);
      --next;  // the last one again
      again_us = t_us() + kArmRetryUs;
    }
    if (autopilot_.armed() && heard_at_tick_.reached) return true;
  }
  return false;
}

bool Sortie::is_lost() const {
  return world_.contact.crashed || !autopilot_.armed() || autopilot_.mode() != Mode::kOffboard;
}

/// The ground station's side: a setpoint a tick, along the approach until the vehicle has settled, then along the plan.
struct Sortie::Stream {
  const Task& task;
  References references;
  const float full_thrust;
  std::uint64_t start_us;
  const Path* path = task.approach.get();
  std::uint64_t near_us = start_us, heard_us = 0, plan_start_us = 0, plan_end_us = 0;
  std::optional<Ending> ended = std::nullopt;

  std::optional<link::SetAttitudeTarget> answer(const Sample& here, bool owns) {
    if (here.t_us <= heard_us && heard_us > 0) return std::nullopt;  // overtaken on the way
    heard_us = here.t_us;
    const double t = elapsed(here);
    if (plan_start_us == 0 && owns && has_settled(here)) {
      path = task.plan.get();
      start_us = plan_start_us = here.t_us;
    } else if (plan_start_us == 0 && t > path->duration() + kSettlesWithin) {
      ended = Ending::kNeverSettled;
    }
    if (plan_start_us > 0) watch(here);
    return target(references.setpoint(*path, start_us, here.t_us, here.estimate), here.t_us);
  }

  double elapsed(const Sample& here) const { return static_cast<double>(here.t_us - start_us) * 1e-6; }

  bool has_settled(const Sample& here) const {
    const Vec3d away = here.estimate.p_WB.cast<double>() - task.start;
    return elapsed(here) >= path->duration() && away.norm() < kStartDistance &&
           here.estimate.v_WB.cast<double>().norm() < kStartSpeed;
  }

  void watch(const Sample& here) {
    const double t = elapsed(here);
    const Derivatives planned = path->at(t);
    const Vec3d error = Vec3d(planned[0][0], planned[0][1], planned[0][2]) - here.estimate.p_WB.cast<double>();
    if (error.norm() < kErrorLimit || near_us < start_us) {
      near_us = here.t_us;
    } else if (here.t_us - near_us > kErrorLimitUs && plan_end_us == 0) {
      ended = Ending::kLeftPlan;
    }
    if (t >= task.duration && plan_end_us == 0) plan_end_us = here.t_us;
    if (t >= task.duration + task.hold_s) ended = ended.value_or(Ending::kFlown);
  }

  link::SetAttitudeTarget target(const Setpoint& setpoint, std::uint64_t t_us) const {
    link::SetAttitudeTarget sent;
    sent.time_boot_ms = static_cast<std::uint32_t>(t_us / 1000);
    sent.q_WD = setpoint.q_WD;
    sent.w_WD_D = setpoint.w_WD_D.cwiseMax(-kBodyRateLargest).cwiseMin(kBodyRateLargest);
    sent.thrust = static_cast<float>(std::clamp(double{setpoint.thrust} / double{full_thrust}, -1.0, 1.0));
    return sent;
  }
};

Ending Sortie::follow(const Task& task, References references, const Bytes& take_over, const RadioSetup& radio) {
  Radio<Sample> down(radio, world_.random, sim::Stream::kTelemetryLink);
  Radio<link::SetAttitudeTarget> up(radio, world_.random, sim::Stream::kReferenceLink);
  references.begin(autopilot_.estimate().q_WB);
  service(take_over, kGroundLink);
  Stream stream{task, std::move(references), autopilot_.params().thrust_reference, t_us()};
  while (true) {
    if (at_tick()) down.send(t_us(), {t_us(), autopilot_.estimate()});
    down.deliver(t_us(), [&](const Sample& here) {
      if (const auto target = stream.answer(here, autopilot_.mode() == Mode::kOffboard)) up.send(t_us(), *target);
    });
    plan_start_us_ = stream.plan_start_us, plan_end_us_ = stream.plan_end_us;
    if (stream.ended) return *stream.ended;
    if (is_lost()) return world_.contact.crashed ? Ending::kCrashed : Ending::kReleased;
    up.deliver(t_us(), [&](const link::SetAttitudeTarget& target) {
      const link::Envelope envelope{static_cast<std::uint8_t>(autopilot_.params().system_id), sequence_++,
                                    link::kGroundComponent};
      const link::TxFrame frame = link::encode_from_ground(target, envelope);
      const link::Datagram received = datagram(frame.bytes.data(), frame.size, kGroundLink);
      hear(autopilot_.service(inputs(received)));
    });
    step();
  }
}

}  // namespace halfroll::stream
