// One number for a whole state. Why: a board tells in four bytes what its autopilot remembers, so a bit that differs is
// seen in its millisecond and not when it has grown into a rotor command.
#pragma once
#include <cstring>
#include <type_traits>

#include "core/types.hpp"

namespace halfroll {

/// FNV-1a over words of 32 bits, of values and never of their layout: padding and pointers differ between processors.
class StateChecksum {
 public:
  std::uint32_t value() const { return hash_; }

  template <class T>
  void add(const T& x) {
    if constexpr (std::is_same_v<T, float>) {
      std::uint32_t bits;
      std::memcpy(&bits, &x, sizeof bits);
      word(bits);
    } else if constexpr (std::is_enum_v<T>) {
      word(static_cast<std::uint32_t>(x));
    } else if constexpr (std::is_integral_v<T>) {
      word(static_cast<std::uint32_t>(x));
      if constexpr (sizeof(T) > 4) word(static_cast<std::uint32_t>(static_cast<std::uint64_t>(x) >> 32U));
    } else {
      parts(x);
    }
  }

 private:
  void word(std::uint32_t bits) { hash_ = (hash_ ^ bits) * 16777619U; }

  template <class T>
  void parts(const T& x) {  // a struct names its own
    add(x.state());
  }
  template <class... T>
  void parts(const std::tuple<T...>& all) {
    std::apply([this](const auto&... each) { (add(each), ...); }, all);
  }
  template <class T, std::size_t N>
  void parts(const std::array<T, N>& all) {
    for (const T& each : all) add(each);
  }
  template <class T>
  void parts(const std::optional<T>& perhaps) {
    add(perhaps.has_value());
    if (perhaps) add(*perhaps);
  }
  template <int Rows, int Columns>
  void parts(const Eigen::Matrix<float, Rows, Columns>& m) {
    for (int i = 0; i < Rows * Columns; ++i) add(m.data()[i]);
  }

  std::uint32_t hash_ = 2166136261U;
};

}  // namespace halfroll
