// Two copies of an image, the newer one in use. Why: a power cut at any moment must leave a whole image, old or new;
// and the rule that sees to it is the same for a file on a disk and for flash pages on a board.
//
// A copy is a header of 32 bytes and the image. A write goes to the region that is not in use: erase, image, flush, and
// only then the header. So whatever is cut short has no sound header, and the other region is untouched.
#pragma once
#include <cstddef>
#include <cstdint>

#include "link/datagram.hpp"

namespace halfroll::boards {

/// Two regions that keep their bytes without power, as flash does: erased whole (to 0xFF), programmed once.
class Medium {
 public:
  virtual std::size_t capacity() const = 0;  // [bytes] of one region
  virtual bool erase(int region) = 0;
  virtual bool program(int region, std::size_t offset, const std::uint8_t* bytes, std::size_t size) = 0;
  /// Whatever was programmed so far outlives a power cut from now on.
  virtual bool flush(int region) = 0;
  /// The bytes that are there, `size` at most; those beyond them read as erased.
  virtual std::size_t read(int region, std::size_t offset, std::uint8_t* bytes, std::size_t size) const = 0;

 protected:
  ~Medium() = default;
};

class TwoSlots {
 public:
  static constexpr std::size_t kHeaderSize = 32;

  /// Looks which copies are sound. The medium must outlive this.
  explicit TwoSlots(Medium& medium);

  /// What there is, and whether all of it was sound.
  link::StoredState state() const { return state_; }
  std::size_t size() const { return state_ == link::StoredState::kNothing ? 0 : size_; }
  /// Where it is: a medium that is memory can be read in place.
  int region() const { return region_; }
  /// The image in use, `size()` bytes; false if the medium gives fewer.
  bool read(std::uint8_t* image) const;

  /// Replace the image. On failure the old one stays in use.
  bool write(const std::uint8_t* image, std::size_t size);

 private:
  Medium& medium_;
  link::StoredState state_ = link::StoredState::kNothing;
  int region_ = 1;  // in use
  std::uint32_t sequence_ = 0;
  std::size_t size_ = 0;
};

}  // namespace halfroll::boards
