#include "boards/cortex_m/semihosting.hpp"

#include <array>
#include <cstring>

namespace halfroll::cortex_m::semihosting {
namespace {

enum class Call : std::uint32_t {
  kOpen = 0x01,
  kWrite = 0x05,
  kRead = 0x06,
  kSeek = 0x0A,
  kCommandLine = 0x15,
  kExit = 0x20
};

int call(Call number, const void* arguments) {
  register auto r0 asm("r0") = static_cast<std::uint32_t>(number);
  register const void* r1 asm("r1") = arguments;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<int>(r0);
}

std::uint32_t word(const void* pointer) { return reinterpret_cast<std::uint32_t>(pointer); }

}  // namespace

int open(const char* name, Mode mode) {
  const std::array<std::uint32_t, 3> arguments = {word(name), static_cast<std::uint32_t>(mode), std::strlen(name)};
  return call(Call::kOpen, arguments.data());
}

std::size_t read(int file, void* into, std::size_t most) {
  const std::array<std::uint32_t, 3> arguments = {static_cast<std::uint32_t>(file), word(into), most};
  const int missing = call(Call::kRead, arguments.data());
  return missing < 0 || static_cast<std::size_t>(missing) > most ? 0 : most - static_cast<std::size_t>(missing);
}

bool write(int file, const void* bytes, std::size_t size) {
  const std::array<std::uint32_t, 3> arguments = {static_cast<std::uint32_t>(file), word(bytes), size};
  return call(Call::kWrite, arguments.data()) == 0;
}

bool seek(int file, std::size_t offset) {
  const std::array<std::uint32_t, 2> arguments = {static_cast<std::uint32_t>(file), offset};
  return call(Call::kSeek, arguments.data()) == 0;
}

bool command_line(char* text, std::size_t size) {
  std::array<std::uint32_t, 2> arguments = {word(text), size};
  return call(Call::kCommandLine, arguments.data()) == 0;
}

void exit(int status) {
  constexpr std::uint32_t kApplicationExit = 0x20026;
  const std::array<std::uint32_t, 2> arguments = {kApplicationExit, static_cast<std::uint32_t>(status)};
  call(Call::kExit, arguments.data());
  for (;;) {
  }
}

}  // namespace halfroll::cortex_m::semihosting
