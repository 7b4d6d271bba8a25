#include "sim/sitl/simulated_vehicle.hpp"

#include <algorithm>
#include <cstdio>

#include "sim/sitl/sensed.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::uint8_t kSevere = 2;  // MAVLink: critical

boards::Start start_from(const Options& options, const VehicleSetup& setup) {
  boards::Start start{setup.vehicle, setup.params, {}};
  start.boot.origin = options.origin;
  start.boot.px4_identity = options.px4_identity;
  start.boot.signing_policies = options.signing;
  start.boot.signing_key = options.signing_key;
  return start;
}

FlightFacts facts_of(const Options& options, const VehicleSetup& setup, const Version& version, std::uint64_t unix_us) {
  return {version.release,  version.commit,    setup.name, options.scenario_called, options.seed,
          options.lockstep, options.arguments, unix_us,    options.origin};
}

}  // namespace

SimulatedVehicle::SimulatedVehicle(const Options& options, const VehicleSetup& setup, const Version& version,
                                   std::unique_ptr<Firmware> firmware, std::uint64_t unix_us_at_wall_0)
    : start_(start_from(options, setup)),
      firmware_(std::move(firmware)),
      model_(setup.plant, options.scenario),
      world_(sim::start(model_, options.seed)),
      orders_(static_cast<std::uint8_t>(setup.params.system_id)) {
  start_.boot.unix_us_at_wall_0 = unix_us_at_wall_0;
  firmware_->start(start_);
  if (options.log.empty()) return;
  log_.emplace(options.log, facts_of(options, setup, version, unix_us_at_wall_0), setup.plant, firmware_->params());
  write_down_start();
}

void SimulatedVehicle::write_down_start() {
  for (const auto slot : {link::StorageSlot::kParams, link::StorageSlot::kMission, link::StorageSlot::kSigning}) {
    log_->heard().image(t_us(), slot, firmware_->stored(slot));
  }
  log_->heard().start(t_us(), start_.boot.unix_us_at_wall_0);
}

LinkOutputs SimulatedVehicle::step(const LinkInputs& heard) {
  if (log_) log_->heard().call(t_us(), Call::kStep, heard);
  Inputs in = sensed(world_);
  in.link = obey(heard);
  const Outputs out = firmware_->step(in);
  for (const float thrust : out.rotors.thrust) commands_.add_float(thrust);
  if (log_) {
    const hil::Shown& shown = firmware_->shown();
    log_->add({t_us(), world_, shown.estimate, shown.reference, out.rotors, shown.mode, shown.armed,
               shown.ground_frames, firmware_->params()});
  }
  write_down(out.link);
  sim::step(model_, world_, out.rotors);
  tell_of_crash();
  ++steps_;
  return out.link;
}

LinkOutputs SimulatedVehicle::service(const LinkInputs& heard) {
  if (log_) log_->heard().call(t_us(), Call::kService, heard);
  const LinkOutputs out = firmware_->service(obey(heard));
  write_down(out);
  return out;
}

LinkInputs SimulatedVehicle::obey(const LinkInputs& heard) {
  answers_.clear();
  passed_.assign(heard.rx, heard.rx + heard.rx_count);
  for (const link::Datagram& datagram : passed_) {
    if (is_cut(datagram.from.link)) continue;
    for (const link::TxFrame& answer : orders_.hear(datagram, t_us(), model_)) answers_.push_back(answer);
  }
  passed_.erase(
      std::remove_if(passed_.begin(), passed_.end(), [&](const auto& each) { return is_cut(each.from.link); }),
      passed_.end());
  LinkInputs in = heard;
  in.rx = passed_.data();
  in.rx_count = passed_.size();
  return in;
}

void SimulatedVehicle::ask_time() {
  if (log_) log_->heard().ask_time(t_us());
  firmware_->ask_time();
}

void SimulatedVehicle::reboot(std::uint64_t unix_us_at_wall_0) {
  start_.boot.unix_us_at_wall_0 = unix_us_at_wall_0;
  firmware_->start(start_);
  if (log_) write_down_start();
  sim::restart_clock(model_, world_);
}

bool SimulatedVehicle::finish() {
  board_report_ = firmware_->finish();
  return !log_ || log_->finish(commands_sha256());
}

void SimulatedVehicle::write_down(const LinkOutputs& out) {
  for (std::size_t i = 0; log_ && i < out.tx_count; ++i) {
    if (out.tx[i].to.link != 0) continue;  // texts go to all links: once is enough
    if (const auto text = said(out.tx[i])) log_->say(t_us(), *text);
  }
}

void SimulatedVehicle::tell_of_crash() {
  if (!world_.contact.crashed || crash_told_) return;
  crash_told_ = true;
  char line[96];
  std::snprintf(line, sizeof line, "crashed at %.3f s, met the ground at %.1f m/s", flown_s(),
                world_.contact.hardest_impact);
  std::fprintf(stderr, "halfroll-sitl: %s\n", line);
  if (log_) log_->say(t_us(), {kSevere, line});
}

}  // namespace halfroll::sitl
