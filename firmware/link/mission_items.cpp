#include "link/mission_items.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace halfroll::link {
namespace {

constexpr float kMost = std::numeric_limits<float>::max();
constexpr std::int32_t kNotGiven = std::numeric_limits<std::int32_t>::max();
constexpr std::int32_t kNotGivenEither = std::numeric_limits<std::int32_t>::min();

using Allowed = ParameterRule;
constexpr Allowed kZero{0.F, 0.F, true, 0.F};      // unused: 0 or NaN
constexpr Allowed kAny{-kMost, kMost, true, 0.F};  // finite or NaN
constexpr Allowed kTime{0.F, kMost, false, 0.F};   // s, needed
constexpr Allowed kFlag{0.F, 1.F, false, 1.F};     // 0 or 1

enum class Place : std::uint8_t {
  kNone,      // x, y, z mean nothing
  kNoneZero,  // x and y must be 0
  kNeeded,    // a real place: not 0,0, height given
  kOptional,  // 0,0 or not given: here
  kIfP1Zero,  // needed unless p1 says "here"
};

struct Row {
  std::uint16_t command;
  ItemKind kind;
  Place place;
  Allowed p[4];
};

constexpr Allowed kRoll{-180.F, 180.F, true, 0.F}, kPitch{-90.F, 90.F, true, 0.F}, kLandMode{0.F, 2.F, false, 1.F};

constexpr Row kRows[] = {
    {cmd::kWaypoint, ItemKind::kWaypoint, Place::kNeeded, {kTime, kTime, kZero, kAny}},
    {cmd::kSplineWaypoint, ItemKind::kWaypoint, Place::kNeeded, {kTime, kZero, kZero, kZero}},
    {cmd::kAttitudeWaypoint, ItemKind::kWaypoint, Place::kNeeded, {kRoll, kPitch, {0.F, kMost, true, 0.F}, kAny}},
    {cmd::kLoiterUnlimited, ItemKind::kWaypoint, Place::kNeeded, {kAny, kAny, kAny, kAny}},
    {cmd::kLoiterTime, ItemKind::kWaypoint, Place::kNeeded, {kTime, kAny, kAny, kAny}},
    {cmd::kTakeoff, ItemKind::kTakeoff, Place::kOptional, {kAny, kZero, kZero, kAny}},
    {cmd::kLand, ItemKind::kLand, Place::kOptional, {kAny, kLandMode, kZero, kAny}},
    {cmd::kReturnToLaunch, ItemKind::kReturn, Place::kNone, {kZero, kZero, kZero, kZero}},
    {cmd::kDelay, ItemKind::kDelay, Place::kNoneZero, {{-1.F, kMost, false, 0.F}, kAny, kAny, kAny}},
    {cmd::kConditionDelay, ItemKind::kDelay, Place::kNone, {kTime, kAny, kAny, kAny}},
    {cmd::kConditionYaw,
     ItemKind::kYaw,
     Place::kNone,
     {{-kMost, kMost, false, 0.F}, kAny, {-1.F, 1.F, true, 1.F}, {0.F, 1.F, true, 1.F}}},
    {cmd::kJump, ItemKind::kJump, Place::kNone, {{0.F, 65535.F, false, 1.F}, {-1.F, 65535.F, false, 1.F}, kAny, kAny}},
    {cmd::kChangeSpeed,
     ItemKind::kSpeed,
     Place::kNone,
     {{0.F, 3.F, false, 1.F}, {-2.F, kMost, false, 0.F}, kAny, kAny}},
    {cmd::kSetHome, ItemKind::kSetHome, Place::kIfP1Zero, {kFlag, kAny, kAny, kAny}},
    {cmd::kLandStart, ItemKind::kSkip, Place::kNone, {kAny, kAny, kAny, kAny}},
    {cmd::kInvertedFlight, ItemKind::kSkip, Place::kNone, {kFlag, kAny, kAny, kAny}},
    {cmd::kFlip,
     ItemKind::kSkip,
     Place::kNone,
     {{1.F, 2.F, false, 1.F}, {-5.F, 5.F, false, 0.5F}, kAny, {0.F, kMost, true, 0.F}}},
};

/// Stored and passed over: nothing here is fitted to obey them.
constexpr std::uint16_t kSkipped[] = {195, 197, 201, 203, 204,  205,  206,  214,  181,  183, 187,
                                      211, 530, 531, 532, 1000, 1001, 2000, 2001, 2500, 2501};
constexpr Row kSkippedRow{0, ItemKind::kSkip, Place::kNone, {kAny, kAny, kAny, kAny}};

const Row* find_row(std::uint16_t command) {
  const auto* row =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& r) { return r.command == command; });
  if (row != std::end(kRows)) return row;
  const bool skipped = std::find(std::begin(kSkipped), std::end(kSkipped), command) != std::end(kSkipped);
  return skipped ? &kSkippedRow : nullptr;
}

bool allowed(const Allowed& rule, float p) {
  if (std::isnan(p)) return rule.open;
  if (!(p >= rule.least && p <= rule.most)) return false;
  return rule.step == 0.F || std::fmod(p, rule.step) == 0.F;
}

/// What no interval can say.
bool allowed_beyond_table(const MissionItem& item, std::size_t i) {
  const float p = item.p[i];
  switch (item.command) {
    case cmd::kDelay: return i != 0 || p == -1.F || p >= 0.F;
    case cmd::kChangeSpeed: return i != 1 || p == -1.F || p == -2.F || p > 0.F;
    case cmd::kFlip: return (i != 1 || p != 0.F) && (i != 3 || p != 0.F);
    case cmd::kAttitudeWaypoint: return i > 1 || !std::isnan(p) || std::isnan(item.p[1 - i]);  // both free or none
    default: return true;
  }
}

bool given(std::int32_t angle) { return angle != kNotGiven && angle != kNotGivenEither; }
bool at_zero(const MissionItem& item) { return item.x == 0 && item.y == 0; }
bool above_home(const MissionItem& item) { return item.frame == kFrameRelative || item.frame == kFrameRelativeInt; }
bool may_be_home(const MissionItem& item) { return item.command == cmd::kWaypoint && item.frame == kFrameGlobal; }

bool has_place(const Row& row, const MissionItem& item) {
  switch (row.place) {
    case Place::kNeeded: return true;
    case Place::kOptional: return given(item.x) && given(item.y) && !at_zero(item);
    case Place::kIfP1Zero: return item.p[0] == 0.F;
    default: return false;
  }
}

bool frame_ok(const Row& row, const MissionItem& item) {
  if (item.frame == kFrameMission)
    return row.place == Place::kNone || row.place == Place::kNoneZero ||
           (row.place == Place::kIfP1Zero && item.p[0] != 0.F);
  return item.command != cmd::kFlip &&
         (item.frame == kFrameGlobal || item.frame == kFrameGlobalInt || above_home(item));
}

MissionResult check_place(const Row& row, const MissionItem& item, int seq, float altitude_max_m) {
  constexpr std::int64_t kQuarter = 900000000, kHalf = 1800000000;
  if (row.place == Place::kNoneZero) {
    if (item.x != 0) return MissionResult::kInvalidParam5;
    return item.y != 0 ? MissionResult::kInvalidParam6 : MissionResult::kAccepted;
  }
  if (has_place(row, item)) {
    const bool judged_later = seq == 0 && may_be_home(item);
    if (std::abs(std::int64_t{item.x}) > kQuarter) return MissionResult::kInvalidParam5;
    if (row.place != Place::kOptional && at_zero(item) && !judged_later) return MissionResult::kInvalidParam5;
    if (std::abs(std::int64_t{item.y}) > kHalf) return MissionResult::kInvalidParam6;
    if (row.place != Place::kOptional && !std::isfinite(item.z)) return MissionResult::kInvalidParam7;
  }
  const bool height_counts = has_place(row, item) || item.command == cmd::kTakeoff;
  if (!height_counts || item.command == cmd::kLand) return MissionResult::kAccepted;
  if (std::isinf(item.z)) return MissionResult::kInvalidParam7;
  const bool too_far = item.z > altitude_max_m || item.z < -100.F;
  return above_home(item) && too_far ? MissionResult::kInvalidParam7 : MissionResult::kAccepted;
}

}  // namespace

std::optional<std::array<ParameterRule, 4>> parameter_rules(std::uint16_t command) {
  const Row* row = find_row(command);
  if (row == nullptr) return std::nullopt;
  return std::array<ParameterRule, 4>{row->p[0], row->p[1], row->p[2], row->p[3]};
}

MissionResult check_item(const MissionItem& item, int seq, float altitude_max_m) {
  const Row* row = find_row(item.command);
  if (row == nullptr) return MissionResult::kUnsupported;
  if (!frame_ok(*row, item)) return MissionResult::kUnsupportedFrame;
  for (std::size_t i = 0; i < item.p.size(); ++i) {
    if (!allowed(row->p[i], item.p[i]) || !allowed_beyond_table(item, i)) {
      return static_cast<MissionResult>(static_cast<int>(MissionResult::kInvalidParam1) + static_cast<int>(i));
    }
  }
  return check_place(*row, item, seq, altitude_max_m);
}

bool first_is_home(const MissionItem* items, int count, int seq0_home) {
  if (count < 1 || seq0_home == 0) return false;
  if (seq0_home == 1) return true;
  return count > 1 && may_be_home(items[0]) && items[1].command == cmd::kTakeoff;
}

void MissionCheck::begin(int count, int seq0_home) {
  *this = MissionCheck{};
  count_ = count;
  seq0_home_ = seq0_home;
  next_ = count - 1;
}

/// Time must pass at this item or wherever it leads: places, ends, and items that only lead to such.
bool MissionCheck::lets_time_pass(const MissionItem* items, int seq) const {
  const MissionItem& item = items[seq];
  const Row* row = find_row(item.command);
  const bool home = seq == 0 && first_is_home(items, count_, seq0_home_);
  const bool place = row != nullptr && !home &&
                     (row->kind == ItemKind::kWaypoint || row->kind == ItemKind::kTakeoff ||
                      row->kind == ItemKind::kLand || row->kind == ItemKind::kReturn);
  const bool jumps = item.command == cmd::kJump && item.p[1] != 0.F;
  return place || (beyond(seq + 1) && (!jumps || beyond(static_cast<int>(item.p[0]))));
}

// Strikes out every item at which time must pass, until a pass finds none. What is left circles.
std::optional<MissionResult> MissionCheck::go_on(const MissionItem* items, int looks) {
  if (count_ > 0 && may_be_home(items[0]) && at_zero(items[0]) && !first_is_home(items, count_, seq0_home_)) {
    return MissionResult::kInvalidParam5;
  }
  for (; looks > 0; --looks) {
    if (next_ < 0) {
      if (!changed_ || struck_ == count_) break;
      changed_ = false;
      next_ = count_ - 1;
    }
    const int seq = next_--;
    const MissionItem& item = items[seq];
    if (item.command == cmd::kJump && !(item.p[0] < static_cast<float>(count_))) return MissionResult::kInvalidParam1;
    if (beyond(seq) || !lets_time_pass(items, seq)) continue;
    passes_[static_cast<std::size_t>(seq)] = changed_ = true;
    ++struck_;
  }
  if (next_ >= 0) return std::nullopt;
  if (struck_ == count_) return MissionResult::kAccepted;
  return changed_ ? std::nullopt : std::optional<MissionResult>(MissionResult::kInvalidParam1);
}

MissionResult check_mission(const MissionItem* items, int count, int seq0_home) {
  MissionCheck check;
  check.begin(count, seq0_home);
  for (;;) {
    if (const std::optional<MissionResult> result = check.go_on(items, kMissionCapacity)) return *result;
  }
}

FlightItem flight_item(const MissionItem& item, const Datum& datum) {
  FlightItem out;
  const Row* row = find_row(item.command);
  if (row == nullptr) return out;
  const auto number = [](float p) { return std::isnan(p) ? 0.F : p; };
  out.kind = row->kind;
  out.has_position = has_place(*row, item);
  if (out.has_position) out.position = local_from_global(datum.origin, {item.x, item.y, datum.origin.alt_mm()});
  const float height = std::isnan(item.z) ? datum.takeoff_altitude : item.z;
  out.position.z() = above_home(item) || std::isnan(item.z) ? datum.home_z + height : height - datum.origin.alt_m();
  const bool turns =
      row->kind == ItemKind::kWaypoint || row->kind == ItemKind::kTakeoff || row->kind == ItemKind::kLand;
  out.has_yaw = turns && item.command != cmd::kSplineWaypoint && !std::isnan(item.p[3]);
  if (out.has_yaw) out.yaw = yaw_from_wire_deg(item.p[3]);
  switch (item.command) {
    case cmd::kWaypoint:
      out.hold_s = item.p[0];
      out.radius = item.p[1];
      break;
    case cmd::kSplineWaypoint:
    case cmd::kLoiterTime:
    case cmd::kConditionDelay: out.hold_s = item.p[0]; break;
    case cmd::kLoiterUnlimited: out.hold_s = std::numeric_limits<float>::infinity(); break;
    case cmd::kDelay: out.hold_s = std::max(item.p[0], 0.F); break;
    case cmd::kConditionYaw: {
      out.has_yaw = true;
      out.yaw_relative = item.p[3] == 1.F;
      out.yaw = yaw_from_wire_deg(item.p[0]);
      if (out.yaw_relative && number(item.p[2]) == -1.F) out.yaw = -out.yaw;
      break;
    }
    case cmd::kJump:
      out.jump_to = static_cast<int>(item.p[0]);
      out.repeats = static_cast<int>(item.p[1]);
      break;
    case cmd::kChangeSpeed:
      if (item.p[0] > 1.F) out.kind = ItemKind::kSkip;  // climb and descent keep their own speeds
      out.speed = item.p[1];
      break;
    default: break;
  }
  return out;
}

OnBoard on_board(const MissionItem& item) {
  if (item.command == cmd::kInvertedFlight || item.command == cmd::kFlip) return OnBoard::kSkipped;
  const bool attitude = item.command == cmd::kAttitudeWaypoint && !std::isnan(item.p[0]);
  return attitude ? OnBoard::kAttitudeNotFlown : OnBoard::kFull;
}

void MissionId::add(const MissionItem* items, int count) {
  for (int i = 0; i < count; ++i) {
    std::array<std::uint8_t, sizeof(MissionItem)> bytes;
    std::memcpy(bytes.data(), &items[i], sizeof(MissionItem));
    for (const std::uint8_t byte : bytes) hash_ = (hash_ ^ byte) * 16777619U;
  }
  count_ += count;
}

std::uint32_t MissionId::id() const {
  if (count_ == 0) return 0;
  return hash_ == 0 ? 1U : hash_;
}

std::uint32_t mission_id(const MissionItem* items, int count) {
  MissionId id;
  id.add(items, count);
  return id.id();
}

}  // namespace halfroll::link
