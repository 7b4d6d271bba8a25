// Parameters. Why: params.def is expanded here once; nothing else lists a parameter.
#pragma once
#include <array>
#include <cstdint>

namespace halfroll {

enum ParamFlag : std::uint8_t { kWhole = 1, kLocked = 2, kReadOnly = 4 };

/// Current values, one member per row of params.def.
struct Params {
#define PARAM(id, field, def, least, most, unit, flags, meaning) float field = def;
#include "core/params.def"
#undef PARAM
};

inline constexpr int kParamCount = sizeof(Params) / sizeof(float);

struct ParamInfo {
  const char* id;  // at most 16 characters
  float Params::* member;
  float default_value, least, most;
  const char* unit;
  std::uint8_t flags;
  const char* meaning;
};

/// Rows in name order; the position is the MAVLink index.
extern const std::array<ParamInfo, kParamCount> kParamTable;

/// Index of `id` (up to 16 characters, terminated or not), or -1.
int find_param(const char* id);

enum class ParamError : std::uint8_t { kNone, kUnknown, kOutOfRange, kReadOnly, kLocked };

/// Store `wanted` if it is finite, inside the range, whole where it must be and allowed now; else say why not.
ParamError set_param(Params& params, int index, float wanted, bool armed);

}  // namespace halfroll
