// CRC-32 (IEEE, reflected). Why: a stored image that was damaged must be known as such before anything in it is used.
#pragma once
#include <cstddef>
#include <cstdint>

namespace halfroll::link {

/// Of `size` bytes; continue a longer sequence by passing the CRC so far.
inline std::uint32_t crc32(const std::uint8_t* bytes, std::size_t size, std::uint32_t so_far = 0) {
  std::uint32_t crc = ~so_far;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ (0xEDB88320U & (0U - (crc & 1U)));
  }
  return ~crc;
}

}  // namespace halfroll::link
