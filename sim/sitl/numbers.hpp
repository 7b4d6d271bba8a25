// Numbers as people type them. Why: "1.5x", "" and "nan" must be refused, and the sentence must name the option.
#pragma once
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>

#include "sim/sitl/bad_option.hpp"

namespace halfroll::sitl {

inline std::string shown(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

/// The number in `text`, from `least` to `most`. Throws BadOption naming `what`.
inline double number(const std::string& what, const std::string& text, double least, double most) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !std::isfinite(x)) throw BadOption(what + " '" + text + "' is not a number");
  if (x < least || x > most) {
    throw BadOption(what + " " + text + " is outside " + shown(least) + " to " + shown(most));
  }
  return x;
}

}  // namespace halfroll::sitl
