#include "link/missions.hpp"

#include <algorithm>
#include <cstring>

namespace halfroll::link {
namespace {

constexpr std::uint32_t kMagic = 0x324D5248;  // "HRM2"
constexpr std::uint64_t kRequestAgainUs = 250000;
constexpr std::uint64_t kRequestSoonestUs = 40000, kRoundTripsToWait = 3;  // for the first repetition
constexpr std::uint64_t kGiveUpUs = 5000000;
constexpr int kLooksPerStep = 32;  // of the whole-mission check
constexpr int kNamedPerStep = 8;   // items hashed

bool is_empty_set(std::uint8_t type) { return type == kTypeFence || type == kTypeRally; }

bool passed(std::uint64_t since_us, std::uint64_t limit_us, const MissionSituation& now) {
  return static_cast<float>(now.t_us - since_us) >= static_cast<float>(limit_us) * std::max(now.time_factor, 1.F);
}

}  // namespace

void MissionService::acknowledge(const Header& to, MissionResult result, std::uint8_t type, Outbox& outbox,
                                 std::uint32_t opaque_id) const {
  outbox.send(to.from, MissionAck{to.sender, result, type, opaque_id});
}

// Reading

void MissionService::receive(const MissionRequestList& asked, const Header& header, const MissionSituation&,
                             Outbox& outbox) {
  if (asked.type != kTypeMission && !is_empty_set(asked.type)) {
    return acknowledge(header, MissionResult::kUnsupported, asked.type, outbox);
  }
  const bool mission = asked.type == kTypeMission;
  const auto n = static_cast<std::uint16_t>(mission ? count() : 0);
  outbox.send(header.from, MissionCount{header.sender, n, asked.type, mission ? id() : 0});
}

void MissionService::receive(const MissionRequest& asked, const Header& header, const MissionSituation&,
                             Outbox& outbox) {
  if (asked.type != kTypeMission && !is_empty_set(asked.type)) {
    return acknowledge(header, MissionResult::kUnsupported, asked.type, outbox);
  }
  if (asked.type != kTypeMission || asked.seq >= count()) {
    return acknowledge(header, MissionResult::kInvalidSequence, asked.type, outbox);
  }
  MissionItemMessage reply;
  reply.target = header.sender;
  reply.seq = asked.seq;
  reply.item = items()[asked.seq];
  reply.current = asked.seq == current_ ? 1 : 0;
  reply.as_int = asked.as_int;
  outbox.send(header.from, reply);
}

void MissionService::receive(const MissionRequestPartial& asked, const Header& header, const MissionSituation&,
                             Outbox& outbox) {
  acknowledge(header, MissionResult::kUnsupported, asked.type, outbox);
}

// Writing

/// Whether this client may begin to write now; if not, it has been told.
bool MissionService::may_write(std::uint8_t type, const Header& header, const MissionSituation& now,
                               Outbox& outbox) const {
  if (phase_ != Phase::kIdle && !is_peer(header)) {
    acknowledge(header, MissionResult::kDenied, type, outbox);
    return false;
  }
  if (now.flying_it) {
    acknowledge(header, MissionResult::kDenied, type, outbox);
    outbox.say(Severity::kWarning, "Mission: busy flying, change mode first");
    return false;
  }
  return phase_ == Phase::kIdle || phase_ == Phase::kReceiving;  // else the answer is on its way
}

void MissionService::begin(const Header& header, int first, int last, const MissionSituation& now, Outbox& outbox) {
  phase_ = Phase::kReceiving;
  peer_ = header;
  reply_type_ = kTypeMission;
  next_ = first;
  last_ = last;
  heard_us_ = now.t_us;
  round_trip_us_ = 0;
  repeats_ = 0;
  request_next(now, outbox);
}

void MissionService::request_next(const MissionSituation& now, Outbox& outbox) {
  requested_us_ = now.t_us;
  outbox.send(peer_.from, MissionRequest{peer_.sender, static_cast<std::uint16_t>(next_), kTypeMission, true});
}

void MissionService::receive(const MissionCount& offered, const Header& header, const MissionSituation& now,
                             Outbox& outbox) {
  if (is_empty_set(offered.type)) {
    const bool empty = offered.count == 0;
    return acknowledge(header, empty ? MissionResult::kAccepted : MissionResult::kUnsupported, offered.type, outbox);
  }
  if (offered.type != kTypeMission) return acknowledge(header, MissionResult::kUnsupported, offered.type, outbox);
  if (!may_write(offered.type, header, now, outbox)) return;
  phase_ = Phase::kIdle;
  if (offered.count > kMissionCapacity) return acknowledge(header, MissionResult::kNoSpace, offered.type, outbox);
  upload().count = offered.count;
  if (offered.count != 0) return begin(header, 0, offered.count - 1, now, outbox);
  clear(header, offered.type, now, outbox);
}

void MissionService::receive(const MissionWritePartial& offered, const Header& header, const MissionSituation& now,
                             Outbox& outbox) {
  if (offered.type != kTypeMission && !is_empty_set(offered.type)) {
    return acknowledge(header, MissionResult::kUnsupported, offered.type, outbox);
  }
  const bool inside = offered.first >= 0 && offered.first <= offered.last && offered.last < count();
  if (is_empty_set(offered.type)) return acknowledge(header, MissionResult::kInvalidSequence, offered.type, outbox);
  if (!may_write(offered.type, header, now, outbox)) return;
  phase_ = Phase::kIdle;
  if (!inside) return acknowledge(header, MissionResult::kInvalidSequence, offered.type, outbox);
  upload() = stored_image();
  begin(header, offered.first, offered.last, now, outbox);
}

void MissionService::receive(const MissionItemMessage& message, const Header& header, const MissionSituation& now,
                             Outbox& outbox) {
  if (phase_ == Phase::kIdle && (message.current == 2 || message.current == 3)) {
    return acknowledge(header, MissionResult::kUnsupported, message.type, outbox);  // old way to fly to a point
  }
  const bool awaited = phase_ == Phase::kReceiving && is_peer(header) && message.type == kTypeMission;
  if (!awaited || message.seq != next_) return;  // a stray must not make us ask again: clients count our requests
  const MissionResult result = check_item(message.item, next_, now.altitude_max);
  if (result != MissionResult::kAccepted) {
    phase_ = Phase::kIdle;
    return acknowledge(header, result, kTypeMission, outbox);
  }
  upload().items[static_cast<std::size_t>(next_)] = message.item;
  heard_us_ = now.t_us;
  if (repeats_ == 0) round_trip_us_ = std::max(now.t_us - requested_us_, (7 * round_trip_us_ + 7) / 8);
  repeats_ = 0;
  ++next_;
  if (next_ <= last_) return request_next(now, outbox);
  finish(now, outbox);
}

void MissionService::receive(const MissionClearAll& asked, const Header& header, const MissionSituation& now,
                             Outbox& outbox) {
  if (is_empty_set(asked.type)) return acknowledge(header, MissionResult::kAccepted, asked.type, outbox);
  if (asked.type != kTypeMission && asked.type != kTypeAll) {
    return acknowledge(header, MissionResult::kUnsupported, asked.type, outbox);
  }
  if (!may_write(asked.type, header, now, outbox)) return;
  phase_ = Phase::kIdle;
  clear(header, asked.type, now, outbox);
}

void MissionService::receive(const MissionAck& message, const Header& header, const MissionSituation&, Outbox&) {
  const bool cancelled = message.result != MissionResult::kAccepted && message.type == kTypeMission;
  if (cancelled && phase_ == Phase::kReceiving && is_peer(header)) phase_ = Phase::kIdle;
}

void MissionService::clear(const Header& header, std::uint8_t type, const MissionSituation& now, Outbox& outbox) {
  if (count() == 0) return acknowledge(header, MissionResult::kAccepted, type, outbox);
  peer_ = header;
  reply_type_ = type;
  upload().count = 0;
  naming_ = {};
  store(now);
}

/// All items are here: judge them together, name them, then to disk. A few at once; more, piece by piece, by step().
void MissionService::finish(const MissionSituation& now, Outbox& outbox) {
  phase_ = Phase::kChecking;
  check_.begin(static_cast<int>(upload().count), now.seq0_home);
  if (static_cast<int>(upload().count) <= kNamedPerStep) go_on(now, outbox);
}

/// One piece, for 2000 items are more than one step can bear.
void MissionService::go_on(const MissionSituation& now, Outbox& outbox) {
  if (phase_ == Phase::kChecking) {
    const std::optional<MissionResult> result = check_.go_on(upload().items.data(), kLooksPerStep);
    if (!result) return;
    if (*result != MissionResult::kAccepted) {
      phase_ = Phase::kIdle;
      return acknowledge(peer_, *result, kTypeMission, outbox);
    }
    phase_ = Phase::kNaming;
    naming_ = {};
    if (static_cast<int>(upload().count) > kNamedPerStep) return;
  }
  const int rest = static_cast<int>(upload().count) - naming_.count();
  naming_.add(upload().items.data() + naming_.count(), std::min(kNamedPerStep, rest));
  if (rest <= kNamedPerStep) store(now);
}

void MissionService::store(const MissionSituation& now) {
  Image& image = upload();
  image.magic = kMagic;
  image.id = naming_.id();
  phase_ = Phase::kStoring;
  heard_us_ = now.t_us;
  write_wanted_ = true;
}

StorageRequest MissionService::take_storage() {
  if (!write_wanted_) return {};
  write_wanted_ = false;
  return {StorageSlot::kMission, reinterpret_cast<const std::uint8_t*>(&upload()),
          kImageHeader + upload().count * sizeof(MissionItem)};
}

void MissionService::stored(bool ok, const MissionSituation&, Outbox& outbox) {
  if (phase_ != Phase::kStoring) return;
  phase_ = Phase::kIdle;
  write_wanted_ = false;
  if (!ok) {
    outbox.say(Severity::kError, "Mission: could not be stored, old one kept");
    return acknowledge(peer_, MissionResult::kError, reply_type_, outbox);
  }
  stored_ = 1U - stored_;
  ++revision_;
  current_ = 0;
  acknowledge(peer_, MissionResult::kAccepted, reply_type_, outbox, id());
}

/// Where the round trip is known a lost frame is asked for once more soon, which is what makes a bad radio bearable;
/// after that at leisure, for clients count how often they are asked.
bool MissionService::must_repeat(const MissionSituation& now) const {
  const bool soon = repeats_ == 0 && round_trip_us_ != 0 && passed(requested_us_, kRequestSoonestUs, now) &&
                    now.t_us - requested_us_ >= kRoundTripsToWait * round_trip_us_;
  return soon || passed(requested_us_, kRequestAgainUs, now);
}

void MissionService::step(const MissionSituation& now, Outbox& outbox) {
  if (phase_ == Phase::kIdle) return;
  if (phase_ == Phase::kChecking || phase_ == Phase::kNaming) return go_on(now, outbox);
  if (passed(heard_us_, kGiveUpUs, now)) {
    if (phase_ == Phase::kStoring) return stored(false, now, outbox);
    phase_ = Phase::kIdle;
    acknowledge(peer_, MissionResult::kOperationCancelled, kTypeMission, outbox);
    outbox.say(Severity::kWarning, "Mission: upload timed out");
  } else if (phase_ == Phase::kReceiving && must_repeat(now)) {
    ++repeats_;
    request_next(now, outbox);
  }
}

bool MissionService::load(const std::uint8_t* bytes, std::size_t size) {
  if (bytes == nullptr || size == 0) return true;
  Image& image = upload();
  if (size < kImageHeader || size > sizeof(Image)) return false;
  std::memcpy(static_cast<void*>(&image), bytes, size);
  const bool sound = image.magic == kMagic && image.count <= kMissionCapacity &&
                     size == kImageHeader + image.count * sizeof(MissionItem) &&
                     image.id == mission_id(image.items.data(), static_cast<int>(image.count));
  if (!sound) {
    image.count = 0;
    return false;
  }
  stored_ = 1U - stored_;
  ++revision_;
  return true;
}

bool MissionService::operator==(const MissionService& o) const {
  const auto same_items = [](const Image& a, const Image& b, std::size_t n) {
    return std::equal(a.items.begin(), a.items.begin() + static_cast<std::ptrdiff_t>(n), b.items.begin());
  };
  const auto small = [](const MissionService& s) {
    return std::tie(s.revision_, s.current_, s.phase_, s.peer_, s.reply_type_, s.next_, s.last_, s.heard_us_,
                    s.requested_us_, s.round_trip_us_, s.repeats_, s.write_wanted_);
  };
  const Image &mine = stored_image(), &other = o.stored_image();
  if (!(small(*this) == small(o)) || mine.count != other.count || !same_items(mine, other, mine.count)) return false;
  if (phase_ == Phase::kIdle) return true;
  const Image &my_upload = images_[1U - stored_], &other_upload = o.images_[1U - o.stored_];
  return my_upload.count == other_upload.count && check_.state() == o.check_.state() && naming_ == o.naming_ &&
         same_items(my_upload, other_upload, my_upload.count);
}

}  // namespace halfroll::link
