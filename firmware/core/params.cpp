#include "core/params.hpp"

#include <cstring>

namespace halfroll {

#define PARAM(id, field, def, least, most, unit, flags, meaning) \
  static_assert(sizeof(id) - 1 <= 16 && (least) <= (def) && (def) <= (most), id);
#include "core/params.def"
#undef PARAM

const std::array<ParamInfo, kParamCount> kParamTable = {{
#define PARAM(id, field, def, least, most, unit, flags, meaning) \
  ParamInfo{id, &Params::field, def, least, most, unit, flags, meaning},
#include "core/params.def"
#undef PARAM
}};

int find_param(const char* id) {
  for (int i = 0; i < kParamCount; ++i) {
    if (std::strncmp(kParamTable[static_cast<std::size_t>(i)].id, id, 16) == 0) return i;
  }
  return -1;
}

ParamError set_param(Params& params, int index, float wanted, bool armed) {
  if (index < 0 || index >= kParamCount) return ParamError::kUnknown;
  const ParamInfo& info = kParamTable[static_cast<std::size_t>(index)];
  if ((info.flags & kReadOnly) != 0) return ParamError::kReadOnly;
  if ((info.flags & kLocked) != 0 && armed) return ParamError::kLocked;
  if (!(wanted >= info.least && wanted <= info.most)) return ParamError::kOutOfRange;  // also NaN
  if ((info.flags & kWhole) != 0 && wanted != static_cast<float>(static_cast<int>(wanted))) {
    return ParamError::kOutOfRange;
  }
  params.*info.member = wanted;
  return ParamError::kNone;
}

}  // namespace halfroll
