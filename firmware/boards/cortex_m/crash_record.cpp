#include "boards/cortex_m/crash_record.hpp"

#include <cstddef>

#include "boards/cortex_m/registers.hpp"
#include "link/checksum.hpp"

namespace halfroll::cortex_m {
namespace {

constexpr std::uint32_t kMagic = 0x48524352;          // "RCRH"
constexpr std::uint32_t kResetRequest = 0x05FA0004U;  // key and SYSRESETREQ

alignas(CrashRecord) [[gnu::section(".noinit")]] std::byte memory[sizeof(CrashRecord)];

CrashRecord& record() { return *reinterpret_cast<CrashRecord*>(memory); }

std::uint32_t checksum() {
  return link::crc32(reinterpret_cast<const std::uint8_t*>(memory), offsetof(CrashRecord, checksum));
}

}  // namespace

void fall(Fall why, std::uint32_t address) {
  record().magic = kMagic;
  record().fall = why;
  record().address = address;
  record().status = scb::fault_status();
  record().checksum = checksum();
  asm volatile("dsb" ::: "memory");
  scb::reset_control() = kResetRequest;
  for (;;) {
  }
}

link::Text<50> take_last_words() {
  const CrashRecord was = record();
  const bool told = was.magic == kMagic && was.checksum == checksum();
  record().magic = 0;
  if (!told) return {};
  link::Text<50> words = was.fall == Fall::kFault      ? "Board: fault at 0x00000000, restarted"
                         : was.fall == Fall::kWatchdog ? "Board: hung at 0x00000000, restarted"
                                                       : "Board: abort at 0x00000000, restarted";
  std::size_t digit = was.fall == Fall::kWatchdog ? 24 : 25;  // the last one
  for (std::uint32_t rest = was.address, n = 0; n < 8; ++n, rest >>= 4U, --digit) {
    words.chars[digit] = "0123456789abcdef"[rest & 15U];
  }
  return words;
}

}  // namespace halfroll::cortex_m
