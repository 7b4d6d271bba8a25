// Which texts may be said now. Why: a fault that repeats each millisecond must not fill the link.
#pragma once
#include <array>
#include <cstdint>
#include <tuple>

#include "link/messages.hpp"

namespace halfroll::link {

/// The same text at most once a second, ten texts a second in all (vehicle time).
class TextLimit {
 public:
  bool allows(const Text<50>& text, std::uint64_t t_us);
  auto state() const { return std::tie(said_, said_us_, next_); }

 private:
  static constexpr int kPerSecond = 10;
  std::array<Text<50>, kPerSecond> said_ = {};  // ring of the last ten
  std::array<std::uint64_t, kPerSecond> said_us_ = {};
  std::uint8_t next_ = 0;
};

}  // namespace halfroll::link
