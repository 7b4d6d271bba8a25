#include "boards/two_slots.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "link/checksum.hpp"

namespace halfroll::boards {
namespace {

constexpr std::uint32_t kMagic = 0x53324852;  // "RH2S"
constexpr std::uint32_t kVersion = 1;         // of this layout; another version is not read

/// Little-endian words in the first 24 bytes of a copy; the rest of its 32 stays erased.
struct Header {
  std::uint32_t magic = kMagic, version = kVersion;
  std::uint32_t sequence = 0;  // the newer of two copies has the next number
  std::uint32_t size = 0;      // [bytes] of the image
  std::uint32_t image_checksum = 0;
  std::uint32_t checksum = 0;  // of the words above

  std::uint32_t own_checksum() const { return link::crc32(reinterpret_cast<const std::uint8_t*>(this), 20); }
};
static_assert(sizeof(Header) == 24, "no padding");

struct Copy {
  std::optional<Header> sound;
  bool blank = false;
};

std::optional<std::uint32_t> checksum_of(const Medium& medium, int region, std::size_t size) {
  std::array<std::uint8_t, 256> piece;
  std::uint32_t crc = 0;
  for (std::size_t done = 0; done < size;) {
    const std::size_t n = std::min(piece.size(), size - done);
    if (medium.read(region, TwoSlots::kHeaderSize + done, piece.data(), n) != n) return std::nullopt;
    crc = link::crc32(piece.data(), n, crc);
    done += n;
  }
  return crc;
}

Copy look(const Medium& medium, int region) {
  std::array<std::uint8_t, 2 * TwoSlots::kHeaderSize> begin;
  begin.fill(0xFF);
  medium.read(region, 0, begin.data(), begin.size());
  Copy copy;
  copy.blank = std::all_of(begin.begin(), begin.end(), [](std::uint8_t byte) { return byte == 0xFF; });
  Header header;
  std::memcpy(&header, begin.data(), sizeof header);
  const bool readable = header.magic == kMagic && header.checksum == header.own_checksum() &&
                        header.version == kVersion && header.size <= medium.capacity() - TwoSlots::kHeaderSize;
  if (readable && checksum_of(medium, region, header.size) == header.image_checksum) copy.sound = header;
  return copy;
}

}  // namespace

TwoSlots::TwoSlots(Medium& medium) : medium_(medium) {
  const std::array<Copy, 2> copies = {look(medium, 0), look(medium, 1)};
  const bool spoiled = (!copies[0].sound && !copies[0].blank) || (!copies[1].sound && !copies[1].blank);
  std::optional<Header> newest;
  for (int region = 0; region < 2; ++region) {
    const std::optional<Header>& header = copies[static_cast<std::size_t>(region)].sound;
    const bool newer = header && (!newest || static_cast<std::int32_t>(header->sequence - newest->sequence) > 0);
    if (!newer) continue;
    newest = header;
    region_ = region;
  }
  if (!newest) {
    state_ = spoiled ? link::StoredState::kLost : link::StoredState::kNothing;
    return;
  }
  state_ = spoiled ? link::StoredState::kOtherCopyDamaged : link::StoredState::kSound;
  sequence_ = newest->sequence;
  size_ = newest->size;
}

bool TwoSlots::read(std::uint8_t* image) const { return medium_.read(region_, kHeaderSize, image, size()) == size(); }

bool TwoSlots::write(const std::uint8_t* image, std::size_t size) {
  const int spare = 1 - region_;
  if (size > medium_.capacity() - kHeaderSize) return false;
  Header header;
  header.sequence = sequence_ + 1;
  header.size = static_cast<std::uint32_t>(size);
  header.image_checksum = link::crc32(image, size);
  header.checksum = header.own_checksum();
  std::array<std::uint8_t, sizeof(Header)> bytes;
  std::memcpy(bytes.data(), &header, sizeof header);
  const bool whole = medium_.erase(spare) && medium_.program(spare, kHeaderSize, image, size) && medium_.flush(spare) &&
                     medium_.program(spare, 0, bytes.data(), bytes.size()) && medium_.flush(spare);
  if (!whole) return false;
  state_ = link::StoredState::kSound;
  region_ = spare;
  sequence_ = header.sequence;
  size_ = size;
  return true;
}

}  // namespace halfroll::boards
