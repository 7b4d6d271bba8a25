// What a user got wrong on the command line. Why: one kind of error, one sentence, one exit code.
#pragma once
#include <stdexcept>

namespace halfroll::sitl {

struct BadOption : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

}  // namespace halfroll::sitl
