// Constants of the loop. Why: one place for the numbers that belong to no vehicle and can never be parameters.
#pragma once
#include <cstdint>

namespace halfroll {

inline constexpr float kGravity = 9.81F;              // [m/s²], reference value of the paper's vehicle
inline constexpr float kDt = 1e-3F;                   // [s], attitude loop
inline constexpr std::uint64_t kStepUs = 1000;        // the same, in vehicle time
inline constexpr std::uint64_t kReferenceUs = 10000;  // period of the outer loop (100 Hz)
inline constexpr float kReferenceDt = 1e-2F;          // [s], the same

}  // namespace halfroll
