#include "link/status_text.hpp"

namespace halfroll::link {

bool TextLimit::allows(const Text<50>& text, std::uint64_t t_us) {
  constexpr std::uint64_t kSecondUs = 1000000;
  for (std::size_t i = 0; i < said_.size(); ++i) {
    const bool recent = said_[i].chars[0] != '\0' && t_us < said_us_[i] + kSecondUs;
    if (recent && (i == next_ || said_[i] == text)) return false;  // next_ is the oldest: ten in this second
  }
  said_[next_] = text;
  said_us_[next_] = t_us;
  next_ = static_cast<std::uint8_t>((next_ + 1) % said_.size());
  return true;
}

}  // namespace halfroll::link
