// Storage pages. Why: memory-mapped flash is read in place, so a stored mission costs no RAM at the start; QEMU has
// none for these boards, so a window of its memory stands for it and a file on the host keeps it.
#pragma once
#include "boards/two_slots.hpp"
#include "link/datagram.hpp"

namespace halfroll::cortex_m {

class Flash {
 public:
  /// The file behind the window; an erased flash if there is none yet. Empty name: nothing outlives the power.
  void open(const char* file_name);

  link::StoredImage stored(link::StorageSlot slot) const;
  link::StorageResult store(const link::StorageRequest& request);

  /// For measurement of power cuts: end all after so many programmed pieces of 32 bytes or erased pages; 0: never.
  void cut_after(std::uint32_t operations) { left_ = operations; }

 private:
  friend class Pages;
  void spend();
  void write_through(std::size_t offset, std::size_t size);

  int file_ = -1;
  std::uint32_t left_ = 0;
};

}  // namespace halfroll::cortex_m
