// The store of two copies on a medium that loses its power at every possible moment.
#include "boards/two_slots.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace halfroll;
using boards::Medium;
using boards::TwoSlots;
using link::StoredState;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// Flash: a programmed byte can only be programmed again after an erase. Dies after `life` bytes or erases.
class Flash final : public Medium {
 public:
  explicit Flash(std::size_t capacity) : regions_{Bytes(capacity, 0xFF), Bytes(capacity, 0xFF)} {}

  std::size_t capacity() const override { return regions_[0].size(); }
  bool erase(int region) override {
    Bytes& bytes = regions_[static_cast<std::size_t>(region)];
    for (std::uint8_t& byte : bytes) {  // not atomic, either
      if (byte == 0xFF) continue;
      if (!lives()) return false;
      byte = 0xFF;
    }
    return true;
  }
  bool program(int region, std::size_t offset, const std::uint8_t* bytes, std::size_t size) override {
    for (std::size_t i = 0; i < size; ++i) {
      if (!lives()) return false;
      std::uint8_t& byte = regions_[static_cast<std::size_t>(region)][offset + i];
      CHECK(byte == 0xFF);
      byte = bytes[i];
    }
    return true;
  }
  bool flush(int) override { return life != 0; }
  std::size_t read(int region, std::size_t offset, std::uint8_t* bytes, std::size_t size) const override {
    const Bytes& from = regions_[static_cast<std::size_t>(region)];
    const std::size_t n = offset < from.size() ? std::min(size, from.size() - offset) : 0;
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(offset), n, bytes);
    return n;
  }
  std::uint8_t& byte(int region, std::size_t offset) { return regions_[static_cast<std::size_t>(region)][offset]; }

  long life = -1;  // -1: for ever

 private:
  bool lives() {
    if (life > 0) --life;
    return life != 0;
  }

  std::array<Bytes, 2> regions_;
};

Bytes image(const TwoSlots& slots) {
  Bytes bytes(slots.size());
  CHECK(slots.read(bytes.data()));
  return bytes;
}

Bytes filled(std::size_t size, std::uint8_t seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(seed + 7U * i);
  return bytes;
}

Flash with_two_writes(const Bytes& first, const Bytes& second) {
  Flash flash(512);
  TwoSlots slots(flash);
  REQUIRE(slots.write(first.data(), first.size()));
  REQUIRE(slots.write(second.data(), second.size()));
  return flash;
}

}  // namespace

TEST_CASE("an erased store holds nothing, and that is no fault") {
  Flash flash(512);
  const TwoSlots slots(flash);
  CHECK(slots.state() == StoredState::kNothing);
  CHECK(slots.size() == 0);
}

TEST_CASE("the last image written is the one found, also an empty one") {
  Flash flash = with_two_writes(filled(100, 1), filled(60, 2));
  CHECK(image(TwoSlots(flash)) == filled(60, 2));
  TwoSlots slots(flash);
  REQUIRE(slots.write(nullptr, 0));
  CHECK(TwoSlots(flash).state() == StoredState::kSound);
  CHECK(image(TwoSlots(flash)).empty());
}

TEST_CASE("wherever the power fails, the store holds the old image or the new one, whole") {
  const Bytes before = filled(90, 1), old = filled(100, 2), wanted = filled(120, 3);
  int kept_old = 0, got_new = 0;
  for (long life = 1; life < 600; ++life) {
    Flash flash = with_two_writes(before, old);
    flash.life = life;
    TwoSlots dying(flash);
    const bool told_ok = dying.write(wanted.data(), wanted.size());
    flash.life = -1;
    const TwoSlots after(flash);
    const Bytes found = image(after);
    CHECK((found == old || found == wanted));
    if (told_ok) CHECK(found == wanted);
    ++(found == old ? kept_old : got_new);
    TwoSlots again(flash);  // and it can be written again
    CHECK(again.write(wanted.data(), wanted.size()));
    CHECK(image(TwoSlots(flash)) == wanted);
  }
  CHECK(kept_old > 200);
  CHECK(got_new > 200);
}

TEST_CASE("a write that is cut short in the image is told at the next start") {
  Flash flash = with_two_writes(filled(90, 1), filled(100, 2));
  flash.life = 90 + 40;  // after the erase
  TwoSlots dying(flash);
  const Bytes wanted = filled(120, 3);
  CHECK_FALSE(dying.write(wanted.data(), wanted.size()));
  flash.life = -1;
  CHECK(TwoSlots(flash).state() == StoredState::kOtherCopyDamaged);
}

TEST_CASE("any flipped bit in the newer copy brings back the older one") {
  for (std::size_t offset : {std::size_t{0}, std::size_t{5}, std::size_t{8}, std::size_t{13}, std::size_t{21},
                             TwoSlots::kHeaderSize, TwoSlots::kHeaderSize + 99}) {
    Flash flash = with_two_writes(filled(90, 1), filled(100, 2));
    flash.byte(1, offset) ^= 0x10;
    const TwoSlots slots(flash);
    CHECK(slots.state() == StoredState::kOtherCopyDamaged);
    CHECK(image(slots) == filled(90, 1));
  }
}

TEST_CASE("with both copies corrupt it is known that something was lost") {
  Flash flash = with_two_writes(filled(90, 1), filled(100, 2));
  flash.byte(0, 40) ^= 1;
  flash.byte(1, 40) ^= 1;
  CHECK(TwoSlots(flash).state() == StoredState::kLost);
  CHECK(TwoSlots(flash).size() == 0);
}

TEST_CASE("an image that does not fit is refused and the old one kept") {
  Flash flash = with_two_writes(filled(90, 1), filled(100, 2));
  TwoSlots slots(flash);
  const Bytes wide = filled(481, 3);
  CHECK_FALSE(slots.write(wide.data(), wide.size()));
  CHECK(image(TwoSlots(flash)) == filled(100, 2));
}
