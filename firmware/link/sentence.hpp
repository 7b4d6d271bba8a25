// A short text put together from words and whole numbers. Why: no printf on board.
#pragma once
#include "link/messages.hpp"

namespace halfroll::link {

/// Sentence("Mission: item ", 3, " refused"); cut at 50 characters.
class Sentence {
 public:
  template <class... Parts>
  explicit Sentence(Parts... parts) {
    (add(parts), ...);
  }
  const Text<50>& text() const { return text_; }

 private:
  void add(const char* words) {
    while (*words != '\0' && size_ < 50) text_.chars[size_++] = *words++;
  }
  void add(int number) {
    char digits[12];
    std::size_t n = sizeof digits;
    digits[--n] = '\0';
    unsigned rest = number < 0 ? 0U - static_cast<unsigned>(number) : static_cast<unsigned>(number);
    do {
      digits[--n] = static_cast<char>('0' + rest % 10U);
      rest /= 10U;
    } while (rest != 0U);
    if (number < 0) digits[--n] = '-';
    add(&digits[n]);
  }

  Text<50> text_;
  std::size_t size_ = 0;
};

}  // namespace halfroll::link
