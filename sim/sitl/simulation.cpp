#include "sim/sitl/simulation.hpp"

#include <algorithm>
#include <cstdio>

#include "boards/host/steady_clock.hpp"
#include "sim/sitl/on_board.hpp"
#include "sim/sitl/pace.hpp"
#include "sim/sitl/sensed.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::uint64_t kAskAgainUs = 100000;     // wall clock, unanswered TIMESYNC
constexpr std::uint64_t kGroundGoneUs = 5000000;  // wall clock without a frame of 191
constexpr std::uint8_t kSevere = 2;               // MAVLink: critical
constexpr int kServiceMs = 20;                    // wall clock between looks at the links while time stands

boards::Start start_from(const Options& options, const VehicleSetup& setup) {
  boards::Start start{setup.vehicle, setup.params, {}};
  start.boot.origin = options.origin;
  start.boot.px4_identity = options.px4_identity;
  start.boot.unix_us_at_wall_0 = host::unix_us() - host::wall_us();
  start.boot.signing_policies = options.signing;
  start.boot.signing_key = options.signing_key;
  return start;
}

std::unique_ptr<Firmware> firmware_for(const Options& options) {
  if (options.board.empty() && options.board_port.empty()) return std::make_unique<InProcess>(options.storage);
  auto channel = options.board.empty() ? std::make_unique<host::ByteChannel>(options.board_port)
                                       : std::make_unique<host::ByteChannel>(options.board, options.storage);
  const std::string nowhere;
  return std::make_unique<OnBoard>(std::move(channel),
                                   options.board_beside ? std::make_unique<InProcess>(nowhere) : nullptr);
}

}  // namespace

Simulation::Simulation(const Options& options, const VehicleSetup& setup, const std::string& version,
                       const volatile std::sig_atomic_t& stop)
    : options_(options),
      setup_(setup),
      stop_(stop),
      links_(options.bind, {{{options.port_offboard, options.peer_offboard},
                             {options.port_gcs, options.peer_gcs},
                             {options.port_companion, options.peer_companion}}}),
      firmware_(firmware_for(options)),
      orders_(static_cast<std::uint8_t>(setup.params.system_id)),
      model_(setup.plant, options.scenario),
      world_(sim::start(model_, options.seed)) {
  firmware_->start(start_from(options_, setup_));
  if (options.log.empty()) return;
  log_.emplace(options.log, FlightFacts{version, setup.name, options.scenario_called, options.seed, options.lockstep},
               firmware_->params());
}

void Simulation::run() {
  bool lockstep = options_.lockstep;
  Pace pace(options_.speed);
  Ground ground = Ground::kAnswered;  // step 0 sends the first telemetry; the first barrier, at t = 0, comes after it
  while (!ending() && ground != Ground::kEnding) {
    if (ground == Ground::kSilent) {
      std::fprintf(stderr, "halfroll-sitl: no ground station for 5 s, leaving lockstep, running on in real time\n");
      lockstep = false;
      pace = Pace(options_.speed > 0.0 ? options_.speed : 1.0);
      ground = Ground::kAnswered;
    }
    pace.wait();
    step(!lockstep);
    if (rebooting_) reboot();
    if (lockstep && firmware_->shown().t_us % kReferenceUs == 0) ground = wait_for_ground();
    if (rebooting_) reboot();
  }
  release();
  board_report_ = firmware_->finish();
  if (log_ && !log_->finish(commands_sha256())) {
    std::fprintf(stderr, "halfroll-sitl: the log %s is not complete, is the disk full?\n", options_.log.c_str());
  }
}

/// One millisecond. In lockstep nobody listens between two barriers: what arrives waits for the next, and so does what
/// is said, lest the ground station wake for every piece of it.
void Simulation::step(bool listening) {
  Inputs in = sensed(world_);
  if (listening) in.link = hear(link::kStepDatagrams, link::kStepBytes / 2);
  in.link.wall_us = host::wall_us();
  const Outputs out = firmware_->step(in);

  for (const float thrust : out.rotors.thrust) commands_.add_float(thrust);
  if (log_) {
    const hil::Shown& shown = firmware_->shown();
    log_->add({steps_ * kStepUs, world_, shown.estimate, shown.reference, out.rotors, shown.mode, shown.armed});
  }
  carry(out.link, listening ? Say::kNow : Say::kAtBarrier);
  sim::step(model_, world_, out.rotors);
  tell_of_crash();
  ++steps_;
}

/// Ask the ground station for the time and stand until it answers; the links are served meanwhile.
Simulation::Ground Simulation::wait_for_ground() {
  const std::uint64_t began_us = host::wall_us();
  std::uint64_t asked_us = began_us;
  ground_heard_us_ = began_us;
  release();  // on all links, before the question goes out on one
  firmware_->ask_time();
  while (!ending()) {
    const LinkInputs in = hear(host::UdpLinks::kAtOnce, host::UdpLinks::kAtOnce * host::UdpLinks::kLongest);
    carry(firmware_->service(in), Say::kNow);
    if (rebooting_) return Ground::kAnswered;  // nobody will: the question went with the clock
    if (firmware_->shown().time_answered) {
      ground_seen_ = true;
      return Ground::kAnswered;
    }
    const std::uint64_t now_us = host::wall_us();
    if (firmware_->shown().ground_frames != ground_frames_) {
      ground_frames_ = firmware_->shown().ground_frames;
      ground_heard_us_ = now_us;
    }
    if (ground_seen_ && now_us - ground_heard_us_ > kGroundGoneUs) return Ground::kSilent;
    if (now_us - asked_us > kAskAgainUs) {
      firmware_->ask_time();
      asked_us = now_us;
    } else if (!firmware_->shown().result_pending && in.rx_count == 0) {
      links_.wait(firmware_->has_links_of_its_own() ? 0 : kServiceMs);
    }
  }
  return Ground::kEnding;
}

LinkInputs Simulation::hear(std::size_t most, std::size_t most_bytes) {
  LinkInputs in;
  in.wall_us = host::wall_us();
  heard_ = links_.receive(in.wall_us, most, most_bytes);
  obey();
  in.rx = heard_.data();
  in.rx_count = heard_.size();
  return in;
}

/// What is addressed to the world and not to the autopilot; what came by a link that is cut never came.
void Simulation::obey() {
  const std::uint64_t t_us = steps_ * kStepUs;
  for (const link::Datagram& datagram : heard_) {
    if (orders_.is_cut(datagram.from.link, t_us)) continue;
    for (const link::TxFrame& answer : orders_.hear(datagram, t_us, model_)) links_.send(answer);
  }
  heard_.erase(std::remove_if(heard_.begin(), heard_.end(),
                              [&](const link::Datagram& each) { return orders_.is_cut(each.from.link, t_us); }),
               heard_.end());
}

void Simulation::carry(const LinkOutputs& out, Say when) {
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (!orders_.is_cut(frame.to.link, steps_ * kStepUs)) {
      if (when == Say::kNow) {
        links_.send(frame);
      } else {
        held_.push_back(frame);
      }
    }
    if (!log_ || frame.to.link != 0) continue;  // texts go to all links: once is enough
    if (const auto text = said(frame)) log_->say(steps_ * kStepUs, *text);
  }
  shut_down_ = shut_down_ || out.shut_down;
  rebooting_ = rebooting_ || out.reboot;
}

void Simulation::release() {
  links_.send(held_);
  held_.clear();
}

/// The autopilot starts again from what is stored, and its clock with it; the vehicle stays where it is.
void Simulation::reboot() {
  firmware_->start(start_from(options_, setup_));
  sim::restart_clock(model_, world_);
  rebooting_ = false;
}

void Simulation::tell_of_crash() {
  if (!world_.contact.crashed || crash_told_) return;
  crash_told_ = true;
  char line[96];
  std::snprintf(line, sizeof line, "crashed at %.3f s, met the ground at %.1f m/s", flown_s(),
                world_.contact.hardest_impact);
  std::fprintf(stderr, "halfroll-sitl: %s\n", line);
  if (log_) log_->say(steps_ * kStepUs, {kSevere, line});
}

bool Simulation::ending() const {
  return stop_ != 0 || shut_down_ || (options_.duration && flown_s() >= *options_.duration);
}

}  // namespace halfroll::sitl
