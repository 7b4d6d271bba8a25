// Parameters and mission over a restart, as files of a directory. Why: a power cut during a write must leave the old
// file whole, so each write goes to a temporary file, to the disk, then takes the place of the old one.
#pragma once
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

  /// Last good image of a slot, empty if there is none.
  const std::vector<std::uint8_t>& stored(link::StorageSlot slot) const { return slot_image(slot); }

  /// Keep a new image; on failure the old one stays.
  link::StorageResult write(const link::StorageRequest& request);

 private:
  bool replace_file(link::StorageSlot slot, const std::uint8_t* bytes, std::size_t size) const;
  std::string path(link::StorageSlot slot) const;
  const std::vector<std::uint8_t>& slot_image(link::StorageSlot slot) const {
    return slot == link::StorageSlot::kMission ? mission_ : params_;
  }

  std::string directory_;
  std::vector<std::uint8_t> params_, mission_;
};

}  // namespace halfroll::host
