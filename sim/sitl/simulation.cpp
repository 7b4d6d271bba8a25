#include "sim/sitl/simulation.hpp"

#include <cstdio>

#include "boards/host/steady_clock.hpp"
#include "sim/sitl/on_board.hpp"
#include "sim/sitl/pace.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::uint64_t kAskAgainUs = 100000;     // wall clock, unanswered TIMESYNC
constexpr std::uint64_t kGroundGoneUs = 5000000;  // wall clock without a frame of 191
constexpr int kServiceMs = 20;                    // wall clock between looks at the links while time stands

std::unique_ptr<Firmware> firmware_for(const Options& options) {
  if (options.board.empty() && options.board_port.empty()) return std::make_unique<InProcess>(options.storage);
  auto channel = options.board.empty() ? std::make_unique<host::ByteChannel>(options.board_port)
                                       : std::make_unique<host::ByteChannel>(options.board, options.storage);
  const std::string nowhere;
  return std::make_unique<OnBoard>(std::move(channel),
                                   options.board_beside ? std::make_unique<InProcess>(nowhere) : nullptr);
}

}  // namespace

Simulation::Simulation(const Options& options, const VehicleSetup& setup, const Version& version,
                       const volatile std::sig_atomic_t& stop)
    : options_(options),
      stop_(stop),
      links_(options.bind, {{{options.port_offboard, options.peer_offboard},
                             {options.port_gcs, options.peer_gcs},
                             {options.port_companion, options.peer_companion}}}),
      vehicle_(options, setup, version, firmware_for(options), host::unix_us() - host::wall_us()) {}

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
    if (lockstep && vehicle_.shown().t_us % kReferenceUs == 0) ground = wait_for_ground();
    if (rebooting_) reboot();
  }
  release();
  if (!vehicle_.finish()) {
    std::fprintf(stderr, "halfroll-sitl: the log %s is not complete, is the disk full?\n", options_.log.c_str());
  }
}

/// One millisecond. In lockstep nobody listens between two barriers: what arrives waits for the next, and so does what
/// is said, lest the ground station wake for every piece of it. The wall's clock is told when something comes, and
/// every 10 ms: the log keeps each time that it is told.
void Simulation::step(bool listening) {
  LinkInputs in;
  if (listening) in = hear(link::kStepDatagrams, link::kStepBytes / 2);
  if (in.rx_count > 0 || vehicle_.t_us() % kReferenceUs == 0) wall_us_ = host::wall_us();
  in.wall_us = wall_us_;
  carry(vehicle_.step(in), listening ? Say::kNow : Say::kAtBarrier);
}

/// Ask the ground station for the time and stand until it answers; the links are served meanwhile. The question goes
/// out behind all that was held back, on every link.
Simulation::Ground Simulation::wait_for_ground() {
  const std::uint64_t began_us = host::wall_us();
  std::uint64_t asked_us = began_us;
  ground_heard_us_ = began_us;
  vehicle_.ask_time();
  while (!ending()) {
    const LinkInputs in = hear(host::UdpLinks::kAtOnce, host::UdpLinks::kAtOnce * host::UdpLinks::kLongest);
    wall_us_ = in.wall_us;
    carry(vehicle_.service(in), Say::kAtBarrier);
    release();
    if (rebooting_) return Ground::kAnswered;  // nobody will: the question went with the clock
    if (vehicle_.shown().time_answered) {
      ground_seen_ = true;
      return Ground::kAnswered;
    }
    const std::uint64_t now_us = host::wall_us();
    if (vehicle_.shown().ground_frames != ground_frames_) {
      ground_frames_ = vehicle_.shown().ground_frames;
      ground_heard_us_ = now_us;
    }
    if (ground_seen_ && now_us - ground_heard_us_ > kGroundGoneUs) return Ground::kSilent;
    if (now_us - asked_us > kAskAgainUs) {
      vehicle_.ask_time();
      asked_us = now_us;
    } else if (!vehicle_.shown().result_pending && in.rx_count == 0) {
      links_.wait(vehicle_.has_links_of_its_own() ? 0 : kServiceMs);
    }
  }
  return Ground::kEnding;
}

LinkInputs Simulation::hear(std::size_t most, std::size_t most_bytes) {
  LinkInputs in;
  in.wall_us = host::wall_us();
  const auto& received = links_.receive(in.wall_us, most, most_bytes);
  in.rx = received.data();
  in.rx_count = received.size();
  return in;
}

void Simulation::carry(const LinkOutputs& out, Say when) {
  for (const link::TxFrame& answer : vehicle_.answers()) links_.send(answer);
  for (std::size_t i = 0; i < out.tx_count; ++i) {
    const link::TxFrame& frame = out.tx[i];
    if (vehicle_.is_cut(frame.to.link)) continue;
    if (when == Say::kNow) {
      links_.send(frame);
    } else {
      held_.push_back(frame);
    }
  }
  shut_down_ = shut_down_ || out.shut_down;
  rebooting_ = rebooting_ || out.reboot;
}

void Simulation::release() {
  links_.send(held_);
  held_.clear();
}

void Simulation::reboot() {
  vehicle_.reboot(host::unix_us() - host::wall_us());
  rebooting_ = false;
}

bool Simulation::ending() const {
  return stop_ != 0 || shut_down_ || (options_.duration && vehicle_.flown_s() >= *options_.duration);
}

}  // namespace halfroll::sitl
