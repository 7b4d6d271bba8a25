// The parameter table. Why: a row out of order would give a MAVLink client another parameter's index.
#include "core/params.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>

namespace halfroll {

TEST_CASE("parameters stand in strict name order and are found by name") {
  for (int i = 0; i < kParamCount; ++i) {
    const ParamInfo& info = kParamTable[static_cast<std::size_t>(i)];
    CAPTURE(info.id);
    CHECK(std::strlen(info.id) <= 16);
    CHECK(find_param(info.id) == i);
    if (i > 0) CHECK(std::strcmp(kParamTable[static_cast<std::size_t>(i - 1)].id, info.id) < 0);
  }
  CHECK(find_param("NO_SUCH") == -1);
  CHECK(find_param("") == -1);
}

TEST_CASE("every parameter starts at its default, takes its limits and nothing beyond") {
  Params params;
  for (int i = 0; i < kParamCount; ++i) {
    const ParamInfo& info = kParamTable[static_cast<std::size_t>(i)];
    CAPTURE(info.id);
    CHECK(params.*info.member == info.default_value);
    const bool read_only = (info.flags & kReadOnly) != 0;
    CHECK(set_param(params, i, info.most, false) == (read_only ? ParamError::kReadOnly : ParamError::kNone));
    CHECK(set_param(params, i, info.least, false) == (read_only ? ParamError::kReadOnly : ParamError::kNone));
    const float kept = params.*info.member;
    const ParamError refused = read_only ? ParamError::kReadOnly : ParamError::kOutOfRange;
    CHECK(set_param(params, i, info.most + 0.01F * (1.F + info.most), false) == refused);
    CHECK(set_param(params, i, info.least - 1.F, false) == refused);
    CHECK(set_param(params, i, NAN, false) == refused);
    CHECK(set_param(params, i, INFINITY, false) == refused);
    CHECK(params.*info.member == kept);
  }
}

TEST_CASE("a whole parameter refuses a fraction, an unknown one everything") {
  Params params;
  CHECK(set_param(params, find_param("SIGN_RULE"), 1.5F, false) == ParamError::kOutOfRange);
  CHECK(set_param(params, find_param("SIGN_RULE"), 2.F, false) == ParamError::kNone);
  CHECK(set_param(params, -1, 0.F, false) == ParamError::kUnknown);
  CHECK(set_param(params, kParamCount, 0.F, false) == ParamError::kUnknown);
}

TEST_CASE("an id of sixteen characters needs no terminator") {
  const char wire[16] = {'C', 'O', 'M', '_', 'D', 'I', 'S', 'A', 'R', 'M', '_', 'P', 'R', 'F', 'L', 'T'};
  CHECK(find_param(wire) >= 0);
}

}  // namespace halfroll
