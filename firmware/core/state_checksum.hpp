// One number for a whole state. Why: a board tells in four bytes what its autopilot remembers, so a bit that differs is
// seen in its millisecond and not when it has grown into a rotor command.
#pragma once
#include <cstring>

#include "core/state_values.hpp"

namespace halfroll {

/// FNV-1a over words of 32 bits, of values and never of their layout: padding and pointers differ between processors.
class StateChecksum {
 public:
  std::uint32_t value() const { return hash_; }

  template <class T>
  void add(const T& x) {
    each_value(x, *this);
  }

  /// One value.
  template <class T>
  void operator()(const T& x) {
    if constexpr (std::is_same_v<T, float>) {
      std::uint32_t bits;
      std::memcpy(&bits, &x, sizeof bits);
      word(bits);
    } else {
      word(static_cast<std::uint32_t>(x));
      if constexpr (std::is_integral_v<T> && sizeof(T) > 4) {
        word(static_cast<std::uint32_t>(static_cast<std::uint64_t>(x) >> 32U));
      }
    }
  }

 private:
  void word(std::uint32_t bits) { hash_ = (hash_ ^ bits) * 16777619U; }

  std::uint32_t hash_ = 2166136261U;
};

}  // namespace halfroll
