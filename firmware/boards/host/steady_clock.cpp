#include "boards/host/steady_clock.hpp"

#include <time.h>

namespace halfroll::host {

namespace {

std::uint64_t read_us(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1000000U + static_cast<std::uint64_t>(now.tv_nsec) / 1000U;
}

}  // namespace

std::uint64_t wall_us() { return read_us(CLOCK_MONOTONIC); }

std::uint64_t unix_us() { return read_us(CLOCK_REALTIME); }

void sleep_until(std::uint64_t us) {
  timespec then{};
  then.tv_sec = static_cast<time_t>(us / 1000000U);
  then.tv_nsec = static_cast<long>(us % 1000000U) * 1000;
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &then, nullptr);
}

}  // namespace halfroll::host
