// The firmware as the simulation sees it. Why: it flies in this process or on a board at the end of a wire, and nothing
// that flies with it needs to know.
#pragma once
#include <utility>
#include <vector>

#include "boards/hil/frames.hpp"
#include "boards/host/storage.hpp"

namespace halfroll::sitl {

class Firmware {
 public:
  virtual ~Firmware() = default;

  /// Power on, or a reboot: the firmware begins from what is stored.
  virtual void start(const boards::Start& start) = 0;
  virtual Outputs step(const Inputs& in) = 0;
  virtual LinkOutputs service(const LinkInputs& in) = 0;
  /// Lockstep: TIMESYNC goes out with the next service.
  virtual void ask_time() = 0;

  /// After the last call.
  virtual const hil::Shown& shown() const = 0;
  virtual const Params& params() const = 0;
  /// What start() finds stored, valid until the next call; nothing where that is not known here.
  virtual link::StoredImage stored(link::StorageSlot slot) const = 0;
  /// Whether it may hear something that does not come through here, as by a serial line of its own.
  virtual bool has_links_of_its_own() const { return false; }
  /// The last words of what has been measured, if anything was; ends a board.
  virtual std::string finish() { return {}; }
};

class InProcess final : public Firmware {
 public:
  explicit InProcess(const std::string& storage_directory) : storage_(storage_directory) {}

  /// As if it had been stored before: for a start that is replayed.
  void keep(link::StorageSlot slot, link::StoredState state, std::vector<std::uint8_t> image) {
    storage_.keep(slot, state, std::move(image));
  }

  void start(const boards::Start& start) override;
  Outputs step(const Inputs& in) override;
  LinkOutputs service(const LinkInputs& in) override;
  void ask_time() override { autopilot_->ask_time(); }
  const hil::Shown& shown() const override { return shown_; }
  const Params& params() const override { return autopilot_->params(); }
  link::StoredImage stored(link::StorageSlot slot) const override { return storage_.stored(slot); }
  std::uint32_t state_checksum() const { return autopilot_->state_checksum(); }

 private:
  void settle(const LinkOutputs& out);

  host::Storage storage_;
  std::optional<Autopilot> autopilot_;
  link::StorageResult stored_;  // not yet told to the autopilot
  hil::Shown shown_;
};

}  // namespace halfroll::sitl
