#include "link/params.hpp"

#include <cstring>

#include "link/checksum.hpp"

namespace halfroll::link {
namespace {

constexpr std::uint64_t kListPeriodUs = 5000;  // 200 a second
constexpr int kMostAtOnce = 16;                // after a pause of the caller
constexpr std::uint32_t kMagic = 0x31505248;   // "HRP1"
constexpr std::size_t kHeaderSize = 12, kRecordSize = 20, kIdSize = 16;

const ParamInfo& row(int index) { return kParamTable[static_cast<std::size_t>(index)]; }

ParamValue shown(int index, const Params& params) {
  return {row(index).id, params.*row(index).member, kParamCount, static_cast<std::uint16_t>(index)};
}

ParamErrorCode wire_error(ParamError error) {
  switch (error) {
    case ParamError::kOutOfRange: return ParamErrorCode::kOutOfRange;
    case ParamError::kReadOnly: return ParamErrorCode::kReadOnly;
    case ParamError::kLocked: return ParamErrorCode::kPermissionDenied;
    default: return ParamErrorCode::kDoesNotExist;
  }
}

std::size_t slot_of(const Endpoint& from, std::size_t slots) { return (from.link * slots + from.slot); }

template <class T>
T read(const std::uint8_t* bytes) {
  T out;
  std::memcpy(&out, bytes, sizeof out);
  return out;
}

}  // namespace

void ParamService::receive(const ParamRequestList&, const Header& header, std::uint64_t wall_us) {
  if (header.from.link >= kLinkCount || header.from.slot >= kSlots) return;
  listings_[slot_of(header.from, kSlots)] = {0, wall_us};
  listing_ = true;
}

void ParamService::receive(const ParamRequestRead& asked, const Header& header, const Params& params, Outbox& outbox) {
  const int index = asked.index == -1 ? find_param(asked.id.c_str()) : asked.index;
  if (index < 0 || index >= kParamCount) {
    outbox.send(header.from, ParamRefusal{header.sender, asked.id, asked.index, ParamErrorCode::kDoesNotExist});
    return;
  }
  outbox.send(header.from, shown(index, params));
}

void ParamService::receive(const ParamSet& wanted, const Header& header, bool armed, std::uint64_t wall_us,
                           Params& params, Outbox& outbox) {
  const auto refuse = [&](ParamErrorCode why) {
    outbox.send(header.from, ParamRefusal{header.sender, wanted.id, -1, why});
  };
  const int index = find_param(wanted.id.c_str());
  if (index < 0) return refuse(ParamErrorCode::kDoesNotExist);
  const ParamError error =
      wanted.type == kParamReal32 ? set_param(params, index, wanted.value, armed) : ParamError::kNone;
  if (wanted.type != kParamReal32 || error != ParamError::kNone) {
    refuse(wanted.type != kParamReal32 ? ParamErrorCode::kTypeMismatch : wire_error(error));
    outbox.send(header.from, shown(index, params));  // after the error: clients without PARAM_ERROR see what holds
    return;
  }
  mark_dirty(wall_us);
  outbox.send(kToAll, shown(index, params));
}

void ParamService::service(std::uint64_t wall_us, const Params& params, Outbox& outbox) {
  if (!listing_) return;
  listing_ = false;
  for (std::size_t i = 0; i < listings_.size(); ++i) {
    Listing& listing = listings_[i];
    const Endpoint to{static_cast<std::uint8_t>(i / kSlots), static_cast<std::uint8_t>(i % kSlots)};
    for (int n = 0; n < kMostAtOnce && listing.next < kParamCount && listing.due_wall_us <= wall_us; ++n) {
      outbox.send(to, shown(listing.next++, params));
      listing.due_wall_us += kListPeriodUs;
    }
    if (listing.due_wall_us < wall_us) listing.due_wall_us = wall_us;
    listing_ = listing_ || listing.next < kParamCount;
  }
}

void ParamService::mark_dirty(std::uint64_t wall_us) {
  if (!dirty_) dirty_since_wall_us_ = wall_us;
  dirty_ = true;
}

StorageRequest ParamService::save(const Params& params) {
  std::size_t size = kHeaderSize;
  std::uint32_t count = 0;
  for (const ParamInfo& info : kParamTable) {
    const float current = params.*info.member;
    if ((info.flags & kReadOnly) != 0 || current == defaults_.*info.member) continue;
    std::memset(&image_[size], 0, kIdSize);
    std::memcpy(&image_[size], info.id, std::strlen(info.id));
    std::memcpy(&image_[size + kIdSize], &current, sizeof current);
    size += kRecordSize;
    ++count;
  }
  std::memcpy(&image_[0], &kMagic, sizeof kMagic);
  std::memcpy(&image_[4], &count, sizeof count);
  const std::uint32_t checksum = crc32(&image_[kHeaderSize], size - kHeaderSize, crc32(&image_[4], 4));
  std::memcpy(&image_[8], &checksum, sizeof checksum);
  dirty_ = urgent_ = false;
  return {StorageSlot::kParams, image_.data(), size};
}

void ParamService::stored(bool ok, std::uint64_t wall_us, Outbox& outbox) {
  if (ok) return;
  mark_dirty(wall_us);
  outbox.say(Severity::kError, "Params: could not be stored");
}

ParamLoad ParamService::load(const std::uint8_t* bytes, std::size_t size, Params& params) const {
  params = defaults_;
  if (bytes == nullptr || size == 0) return ParamLoad::kLoaded;
  if (size < kHeaderSize || read<std::uint32_t>(bytes) != kMagic) return ParamLoad::kDamaged;
  const std::size_t count = read<std::uint32_t>(bytes + 4);
  if (count > (size - kHeaderSize) / kRecordSize || size != kHeaderSize + count * kRecordSize)
    return ParamLoad::kDamaged;
  if (read<std::uint32_t>(bytes + 8) != crc32(bytes + kHeaderSize, size - kHeaderSize, crc32(bytes + 4, 4))) {
    return ParamLoad::kDamaged;
  }
  ParamLoad result = ParamLoad::kLoaded;
  for (const std::uint8_t* record = bytes + kHeaderSize; record != bytes + size; record += kRecordSize) {
    Text<kIdSize> id;
    std::memcpy(id.chars.data(), record, kIdSize);
    const int index = find_param(id.c_str());
    if (set_param(params, index, read<float>(record + kIdSize), false) != ParamError::kNone) {
      result = ParamLoad::kUnknownNames;
    }
  }
  return result;
}

void ParamService::reset(Params& params, std::uint64_t wall_us) {
  for (const ParamInfo& info : kParamTable) {
    if ((info.flags & kReadOnly) == 0) params.*info.member = defaults_.*info.member;
  }
  mark_dirty(wall_us);
}

}  // namespace halfroll::link
