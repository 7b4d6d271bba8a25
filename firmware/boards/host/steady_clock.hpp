// The host's monotonic clock. Why: pacing and link service need one; the firmware must never see it as time.
#pragma once
#include <cstdint>

namespace halfroll::host {

std::uint64_t wall_us();

/// The time of day; for time stamps that others read, never for pacing.
std::uint64_t unix_us();

/// Sleep until wall_us() reaches `us`; earlier when a signal comes.
void sleep_until(std::uint64_t us);

}  // namespace halfroll::host
