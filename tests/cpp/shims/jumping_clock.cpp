// The time of day as a bad time server sets it: back and forth by hours, several times a second. Preloaded into a
// process. Why: vehicle time is the step count; who reads the time of day by mistake flies another flight.
#include <dlfcn.h>
#include <time.h>

extern "C" int clock_gettime(clockid_t clock, timespec* now) {
  using ClockGettime = int (*)(clockid_t, timespec*);
  static const auto real = reinterpret_cast<ClockGettime>(dlsym(RTLD_NEXT, "clock_gettime"));
  const int result = real(clock, now);
  if (result == 0 && clock == CLOCK_REALTIME) now->tv_sec += now->tv_nsec / 100000000 % 2 == 0 ? 7200 : -7200;
  return result;
}
