// What a disk may hand back at boot: the two copies of a store, or an image of parameters, mission or signing, with any
// bytes in them. The first byte says which, and whether the checksums are made to match.
#include <algorithm>
#include <cstring>

#include "boards/two_slots.hpp"
#include "link/checksum.hpp"
#include "sim/sitl/checked.hpp"
#include "sim/sitl/vehicle_file.hpp"

namespace {

using namespace halfroll;
using sitl::fail;
using Bytes = std::vector<std::uint8_t>;

/// Flash that a fuzzer has written.
class Found final : public boards::Medium {
 public:
  static constexpr std::size_t kSize = 4096;

  Found(const std::uint8_t* data, std::size_t size) {
    const std::size_t half = size / 2;
    regions_[0].assign(data, data + std::min(half, kSize));
    regions_[1].assign(data + half, data + half + std::min(size - half, kSize));
  }
  std::size_t capacity() const override { return kSize; }
  bool erase(int region) override {
    at(region).clear();
    return true;
  }
  bool program(int region, std::size_t offset, const std::uint8_t* bytes, std::size_t size) override {
    if (offset + size > kSize) return false;
    if (at(region).size() < offset + size) at(region).resize(offset + size, 0xFF);
    std::copy_n(bytes, size, at(region).begin() + static_cast<std::ptrdiff_t>(offset));
    return true;
  }
  bool flush(int) override { return true; }
  std::size_t read(int region, std::size_t offset, std::uint8_t* bytes, std::size_t size) const override {
    const Bytes& from = regions_[static_cast<std::size_t>(region)];
    const std::size_t there = offset < from.size() ? std::min(size, from.size() - offset) : 0;
    std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(std::min(offset, from.size())), there, bytes);
    std::fill_n(bytes + there, size - there, std::uint8_t{0xFF});
    return there;
  }

 private:
  Bytes& at(int region) { return regions_[static_cast<std::size_t>(region)]; }
  Bytes regions_[2];
};

/// Whatever was there: what is written next is what is read next.
void use_store(const std::uint8_t* data, std::size_t size) {
  Found medium(data, size);
  boards::TwoSlots store(medium);
  Bytes image(store.size());
  if (store.state() == link::StoredState::kSound && !store.read(image.data())) fail("a sound store gives nothing", 0);
  const Bytes fresh(data, data + std::min<std::size_t>(size, 1000));
  if (!store.write(fresh.data(), fresh.size())) fail("a store refuses to be written", 0);
  const boards::TwoSlots again(medium);
  Bytes got(again.size());
  if (again.size() != fresh.size() || !again.read(got.data()) || got != fresh)
    fail("a store forgot what was written", 0);
}

void put(Bytes& image, std::size_t at, std::uint32_t word) {
  if (image.size() >= at + 4) std::memcpy(&image[at], &word, 4);
}

/// A vehicle that boots from these and stands for a moment.
void boot(const Bytes& params, const Bytes& mission, const Bytes& signing) {
  static const sitl::VehicleSetup setup = sitl::make_vehicle("mit-vp", {});
  const auto image = [](const Bytes& bytes) {
    return bytes.empty() ? link::StoredImage{}
                         : link::StoredImage{link::StoredState::kSound, bytes.data(), bytes.size()};
  };
  Boot from;
  from.params = image(params);
  from.mission = image(mission);
  from.signing = image(signing);
  Autopilot autopilot(setup.vehicle, setup.params, from);
  for (std::uint64_t t_us = 0; t_us < 30000; t_us += 1000) {
    Inputs in;
    in.measured.imu.specific_force_B = {0.F, 0.F, kGravity};
    sitl::checked_step(autopilot, in);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::uint8_t what = data[0] % 4;
  const bool sealed = data[0] >= 128;
  Bytes image(data + 1, data + size);
  if (what == 0) {
    use_store(data + 1, size - 1);
  } else if (what == 1) {
    if (sealed) {
      put(image, 0, 0x31505248);
      put(image, 4, static_cast<std::uint32_t>((image.size() - std::min<std::size_t>(image.size(), 12)) / 20));
      if (image.size() >= 12) put(image, 8, link::crc32(&image[12], image.size() - 12, link::crc32(&image[4], 4)));
    }
    boot(image, {}, {});
  } else if (what == 2) {
    if (sealed && image.size() >= 12) {
      const std::size_t count = (image.size() - 12) / sizeof(link::MissionItem);
      image.resize(12 + count * sizeof(link::MissionItem));
      std::vector<link::MissionItem> items(count);
      if (count > 0) std::memcpy(items.data(), &image[12], count * sizeof(link::MissionItem));
      put(image, 0, 0x324D5248);
      put(image, 4, static_cast<std::uint32_t>(count));
      put(image, 8, link::mission_id(items.data(), static_cast<int>(count)));
    }
    boot({}, image, {});
  } else {
    if (sealed) {
      image.resize(48);
      put(image, 0, 0x31535248);
      put(image, 44, link::crc32(image.data(), 44));
    }
    boot({}, {}, image);
  }
  return 0;
}
