// The parameter service. Why: clients of both families must list, read and set the same floats without surprises.
#pragma once
#include "core/params.hpp"
#include "link/outbox.hpp"

namespace halfroll::link {

/// kUnknownNames: some names or values of the image mean nothing here and were left out.
enum class ParamLoad : std::uint8_t { kLoaded, kUnknownNames, kDamaged };

class ParamService {
 public:
  static constexpr std::size_t kImageCapacity = 12 + 20 * static_cast<std::size_t>(kParamCount);

  /// What "default" means: the values before anything stored is applied.
  explicit ParamService(const Params& defaults = {}) : defaults_(defaults) {}

  void receive(const ParamRequestList&, const Header&, std::uint64_t wall_us);
  void receive(const ParamRequestRead&, const Header&, const Params&, Outbox&);
  void receive(const ParamSet&, const Header&, bool armed, std::uint64_t wall_us, Params&, Outbox&);

  /// Send what of the running lists is due: 200 per second of wall time to each asker.
  void service(std::uint64_t wall_us, const Params&, Outbox&);

  /// Values changed more than half a second ago (wall) and not yet stored.
  bool save_due(std::uint64_t wall_us) const { return dirty_ && (urgent_ || wall_us >= dirty_since_wall_us_ + 500000); }
  /// Store what is not yet stored now; false if there is nothing.
  bool save_at_once() { return urgent_ = dirty_; }
  /// Store them even if nothing has changed.
  void touch(std::uint64_t wall_us) { mark_dirty(wall_us); }
  /// Make the image of what differs from the defaults; valid until the next call. Counts as saved.
  StorageRequest save(const Params&);
  /// A failed write is tried again, and said.
  void stored(bool ok, std::uint64_t wall_us, Outbox&);

  /// Defaults, then the image over them. Damaged or empty: defaults alone (empty is kLoaded).
  ParamLoad load(const std::uint8_t* bytes, std::size_t size, Params&) const;
  void reset(Params& params, std::uint64_t wall_us);  // all but the read-only ones

  /// Wall times are not part of the state: they pace, they decide nothing.
  auto state() const { return std::tie(dirty_); }

 private:
  struct Listing {
    int next = kParamCount;  // at the end: nothing asked
    std::uint64_t due_wall_us = 0;
  };
  static constexpr int kSlots = 9;  // endpoints of a link

  void mark_dirty(std::uint64_t wall_us);

  Params defaults_;
  bool listing_ = false;  // to anybody
  std::array<Listing, static_cast<std::size_t>(kLinkCount* kSlots)> listings_ = {};
  bool dirty_ = false, urgent_ = false;
  std::uint64_t dirty_since_wall_us_ = 0;
  std::array<std::uint8_t, kImageCapacity> image_ = {};
};

}  // namespace halfroll::link
