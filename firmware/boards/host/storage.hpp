// What outlives a restart, as files of a directory: two for each image (boards/two_slots.hpp).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "link/datagram.hpp"

namespace halfroll::host {

class Storage {
 public:
  /// Read what is stored. Without a directory ("") nothing outlives the process. Makes the directory if it is missing;
  /// throws std::runtime_error if that fails.
  explicit Storage(std::string directory);

  /// Last good image of a slot, empty if there is none; valid until the next write.
  link::StoredImage stored(link::StorageSlot slot) const;

  /// Keep a new image; on failure the old one stays.
  link::StorageResult write(const link::StorageRequest& request);

  /// What a slot shall hold while the process lives, on no medium.
  void keep(link::StorageSlot slot, link::StoredState state, std::vector<std::uint8_t> image);

 private:
  struct Kept {
    link::StoredState state = link::StoredState::kNothing;
    std::vector<std::uint8_t> image;
  };

  std::string path(link::StorageSlot slot) const;

  std::string directory_;
  std::array<Kept, link::kStorageSlotCount> kept_;  // by slot
};

}  // namespace halfroll::host
