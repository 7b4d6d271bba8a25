// SHA-256 (FIPS 180-4). Why: signatures of frames, and one line that tells whether two flights gave the rotors the same
// commands, bit for bit.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace halfroll::link {

class Sha256 {
 public:
  void add(const void* bytes, std::size_t size);
  /// Its four bytes, lowest first, whatever the machine's order.
  void add_float(float x);
  /// Of what was added so far; more may be added afterwards.
  std::array<std::uint8_t, 32> digest() const;
  /// The same as 64 lower-case hexadecimal digits, terminated.
  std::array<char, 65> hex() const;

 private:
  void compress();

  std::array<std::uint32_t, 8> hash_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                        0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> block_ = {};
  std::uint64_t size_ = 0;  // [bytes], all blocks
};

}  // namespace halfroll::link
