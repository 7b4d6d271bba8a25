// Files and pipes of the machine that a debugger, or QEMU, runs on. Why: the fastest way into an emulated board, and on
// a real one the way through its debug probe.
#pragma once
#include <cstddef>
#include <cstdint>

namespace halfroll::cortex_m::semihosting {

enum class Mode : std::uint32_t { kRead = 1, kUpdate = 3, kWrite = 5, kCreate = 7 };  // as fopen's rb, r+b, wb, w+b

/// A handle, or -1.
int open(const char* name, Mode mode);
/// Bytes read; fewer than asked for at the end, or where a pipe has no more at once.
std::size_t read(int file, void* into, std::size_t most);
/// False unless all was written.
bool write(int file, const void* bytes, std::size_t size);
bool seek(int file, std::size_t offset);
/// Words of the command line into `text`, separated by single blanks; false if it does not fit.
bool command_line(char* text, std::size_t size);
[[noreturn]] void exit(int status);

}  // namespace halfroll::cortex_m::semihosting
