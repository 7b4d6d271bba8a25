#include "sim/sitl/firmware.hpp"

#include <utility>

#include "sim/sitl/checked.hpp"

namespace halfroll::sitl {

void InProcess::start(const boards::Start& start) {
  Boot boot = start.boot;
  boot.params = storage_.stored(link::StorageSlot::kParams);
  boot.mission = storage_.stored(link::StorageSlot::kMission);
  boot.signing = storage_.stored(link::StorageSlot::kSigning);
  autopilot_.emplace(start.vehicle, start.params, boot);
  stored_ = {};
  shown_ = {};
}

Outputs InProcess::step(const Inputs& in) {
  Inputs told = in;
  told.link.stored = std::exchange(stored_, {});
  const Outputs out = sitl::step(*autopilot_, told);
  settle(out.link);
  return out;
}

LinkOutputs InProcess::service(const LinkInputs& in) {
  LinkInputs told = in;
  told.stored = std::exchange(stored_, {});
  const LinkOutputs out = autopilot_->service(told);
  settle(out);
  return out;
}

void InProcess::settle(const LinkOutputs& out) {
  if (out.store.slot != link::StorageSlot::kNone) stored_ = storage_.write(out.store);
  shown_.t_us = autopilot_->t_us();
  shown_.mode = static_cast<std::uint8_t>(autopilot_->mode());
  shown_.armed = autopilot_->armed();
  shown_.time_answered = autopilot_->time_answered();
  shown_.result_pending = stored_.slot != link::StorageSlot::kNone;
  shown_.ground_frames = autopilot_->ground_frames();
  shown_.estimate = autopilot_->estimate();
  shown_.reference = autopilot_->reference();
}

}  // namespace halfroll::sitl
