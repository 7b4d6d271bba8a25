#include "boards/cortex_m/flash.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "boards/cortex_m/semihosting.hpp"

extern "C" std::uint8_t flash_pages_begin[];  // linker script

namespace halfroll::cortex_m {
namespace {

constexpr std::size_t kPage = 4096, kPiece = 32;
struct Place {
  std::size_t first_page, pages;  // of one region; the other follows
};
/// By slot; the sizes are what the images need.
constexpr std::array<Place, link::kStorageSlotCount> kPlaces = {{{0, 0}, {0, 1}, {4, 16}, {2, 1}}};
constexpr std::size_t kPages = 36;

std::uint8_t* window() { return flash_pages_begin; }

}  // namespace

/// The two regions of one slot.
class Pages final : public boards::Medium {
 public:
  Pages(Flash& flash, link::StorageSlot slot) : flash_(flash), place_(kPlaces[static_cast<std::size_t>(slot)]) {}

  std::size_t capacity() const override { return place_.pages * kPage; }
  bool erase(int region) override {
    for (std::size_t page = 0; page < place_.pages; ++page) {
      flash_.spend();
      const std::size_t offset = begin(region) + page * kPage;
      std::memset(window() + offset, 0xFF, kPage);
      flash_.write_through(offset, kPage);
    }
    return true;
  }
  bool program(int region, std::size_t offset, const std::uint8_t* bytes, std::size_t size) override {
    for (std::size_t done = 0; done < size; done += kPiece) {
      flash_.spend();
      const std::size_t n = std::min(kPiece, size - done), here = begin(region) + offset + done;
      for (std::size_t i = 0; i < n; ++i) window()[here + i] &= bytes[done + i];  // bits are only ever cleared
      if (std::memcmp(window() + here, bytes + done, n) != 0) return false;
      flash_.write_through(here, n);
    }
    return true;
  }
  bool flush(int) override { return true; }  // program() has waited for it
  std::size_t read(int region, std::size_t offset, std::uint8_t* bytes, std::size_t size) const override {
    std::memcpy(bytes, image(region) + offset, size);
    return size;
  }
  const std::uint8_t* image(int region) const { return window() + begin(region); }

 private:
  std::size_t begin(int region) const {
    return (place_.first_page + static_cast<std::size_t>(region) * place_.pages) * kPage;
  }

  Flash& flash_;
  Place place_;
};

void Flash::open(const char* file_name) {
  std::memset(window(), 0xFF, kPages * kPage);
  if (file_name[0] == '\0') return;
  file_ = semihosting::open(file_name, semihosting::Mode::kUpdate);
  if (file_ >= 0) {
    semihosting::read(file_, window(), kPages * kPage);
    return;
  }
  file_ = semihosting::open(file_name, semihosting::Mode::kCreate);
  write_through(0, kPages * kPage);
}

/// One operation nearer to the end of the power.
void Flash::spend() {
  constexpr int kPowerCut = 5;
  if (left_ != 0 && --left_ == 0) semihosting::exit(kPowerCut);
}

void Flash::write_through(std::size_t offset, std::size_t size) {
  if (file_ < 0) return;
  semihosting::seek(file_, offset);
  semihosting::write(file_, window() + offset, size);
}

link::StoredImage Flash::stored(link::StorageSlot slot) const {
  Pages pages(const_cast<Flash&>(*this), slot);
  const boards::TwoSlots slots(pages);
  return {slots.state(), pages.image(slots.region()) + boards::TwoSlots::kHeaderSize, slots.size()};
}

link::StorageResult Flash::store(const link::StorageRequest& request) {
  if (request.slot == link::StorageSlot::kNone) return {};
  Pages pages(*this, request.slot);
  return {request.slot, boards::TwoSlots(pages).write(request.bytes, request.size)};
}

}  // namespace halfroll::cortex_m
