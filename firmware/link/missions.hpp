// Mission transfer. Why: reading is stateless and always possible; writing is one upload at a time into a buffer of its
// own, so the stored mission is replaced whole, after it is on disk, or not at all.
#pragma once
#include "core/params.hpp"
#include "link/mission_items.hpp"
#include "link/outbox.hpp"

namespace halfroll::link {

/// What the transfer must know of the flight.
struct MissionSituation {
  std::uint64_t t_us = 0;
  float time_factor = 1.F;     // k of a faster than real-time simulator: link timers are this much longer
  bool flying_it = false;      // armed with mission_state 3
  int seq0_home = 2;           // MIS_SEQ0_HOME
  float altitude_max = 500.F;  // MIS_ALT_MAX
};

class MissionService {
 public:
  void receive(const MissionRequestList&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionRequest&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionRequestPartial&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionCount&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionWritePartial&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionItemMessage&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionClearAll&, const Header&, const MissionSituation&, Outbox&);
  void receive(const MissionAck&, const Header&, const MissionSituation&, Outbox&);

  /// Timers: re-request, give up; a piece of the check of a long mission. Call every step.
  void step(const MissionSituation&, Outbox&);

  /// The image to write, once per upload or clear; slot kNone when there is nothing to write.
  StorageRequest take_storage();
  /// The write's outcome: swap in and acknowledge, or ACK ERROR and keep the old mission.
  void stored(bool ok, const MissionSituation&, Outbox&);

  /// From the stored image at boot. False: damaged (no mission then). Empty is fine.
  bool load(const std::uint8_t* bytes, std::size_t size);

  const MissionItem* items() const { return stored_image().items.data(); }
  int count() const { return static_cast<int>(stored_image().count); }
  std::uint32_t id() const { return stored_image().id; }
  /// Grows whenever the stored mission is replaced or cleared: progress starts again.
  std::uint32_t revision() const { return revision_; }
  bool uploading() const { return phase_ != Phase::kIdle; }

  /// Shown as `current` in downloads; the autopilot keeps it.
  void set_current(int seq) { current_ = seq; }

  bool operator==(const MissionService& o) const;

 private:
  enum class Phase : std::uint8_t { kIdle, kReceiving, kChecking, kNaming, kStoring };
  /// Byte for byte what is on disk; the id tells damaged items, for it is their hash.
  struct Image {
    std::uint32_t magic = 0;
    std::uint32_t count = 0;
    std::uint32_t id = 0;
    std::array<MissionItem, kMissionCapacity> items = {};
  };
  static constexpr std::size_t kImageHeader = 12;
  static_assert(sizeof(Image) == kImageHeader + kMissionCapacity * sizeof(MissionItem), "no padding");

  const Image& stored_image() const { return images_[stored_]; }
  Image& upload() { return images_[1U - stored_]; }
  bool is_peer(const Header& header) const { return peer_.sender == header.sender && peer_.from == header.from; }
  bool may_write(std::uint8_t type, const Header&, const MissionSituation&, Outbox&) const;
  void acknowledge(const Header&, MissionResult, std::uint8_t type, Outbox&, std::uint32_t opaque_id = 0) const;
  void request_next(const MissionSituation&, Outbox&);
  bool must_repeat(const MissionSituation&) const;
  void begin(const Header&, int first, int last, const MissionSituation&, Outbox&);
  void finish(const MissionSituation&, Outbox&);
  void go_on(const MissionSituation&, Outbox&);
  void clear(const Header&, std::uint8_t type, const MissionSituation&, Outbox&);
  void store(const MissionSituation&);

  std::array<Image, 2> images_ = {};
  std::size_t stored_ = 0;
  std::uint32_t revision_ = 0;
  int current_ = 0;

  Phase phase_ = Phase::kIdle;
  Header peer_;
  std::uint8_t reply_type_ = kTypeMission;
  int next_ = 0, last_ = 0;
  std::uint64_t heard_us_ = 0;       // t_last
  std::uint64_t requested_us_ = 0;   // t_req
  std::uint64_t round_trip_us_ = 0;  // of this upload, its slow side; 0: not known yet
  std::uint8_t repeats_ = 0;         // of the request that is out
  bool write_wanted_ = false;
  MissionCheck check_;
  MissionId naming_;  // of the items so far
};

}  // namespace halfroll::link
