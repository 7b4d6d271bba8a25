// MPS2 under QEMU, or on a desk: sensors and rotors by semihosted pipes, MAVLink also by UART.
//
// Its command line: NAME PIPE_IN PIPE_OUT [FLASH_FILE [CUT_AFTER]].
#include <array>
#include <cstdlib>
#include <cstring>

#include "boards/cortex_m/clock.hpp"
#include "boards/cortex_m/crash_record.hpp"
#include "boards/cortex_m/flash.hpp"
#include "boards/cortex_m/semihosting.hpp"
#include "boards/cortex_m/stack.hpp"
#include "boards/cortex_m/uart.hpp"
#include "boards/hil/hil_board.hpp"

void board_main();

namespace halfroll::cortex_m {
namespace {

class Pipes final : public hil::Channel {
 public:
  void open(const char* in, const char* out) {
    in_ = semihosting::open(in, semihosting::Mode::kRead);
    out_ = semihosting::open(out, semihosting::Mode::kWrite);
  }
  std::size_t read(std::uint8_t* into, std::size_t most) override { return semihosting::read(in_, into, most); }
  void write(const std::uint8_t* bytes, std::size_t size) override { semihosting::write(out_, bytes, size); }

 private:
  int in_ = -1, out_ = -1;
};

class Mps2 final : public hil::Host {
 public:
  Flash flash;
  link::Text<50> words;

  link::StoredImage stored(link::StorageSlot slot) override { return flash.stored(slot); }
  link::StorageResult store(const link::StorageRequest& request) override { return flash.store(request); }
  /// QEMU's -icount shift=3 gives an instruction 8 ns: five in a tick of the 25 MHz clock.
  std::uint32_t instructions() override {
    clock::feed_watchdog();
    return kInstructionsPerTick * clock::ticks();
  }
  std::uint32_t instructions_per_step() override { return kInstructionsPerTick * clock::kTicksPerStep; }
  std::uint32_t stack_bytes() override { return stack_used(); }
  link::Datagram heard() override { return {{0, 0}, heard_.data(), uart::receive(heard_.data(), heard_.size())}; }
  void say(const link::TxFrame& frame) override {
    if (frame.to.link == 0 && (frame.to.slot == 0 || frame.to.slot == link::kEveryone)) {
      uart::send(frame.bytes.data(), frame.size);
    }
  }
  const char* last_words() override { return words.c_str(); }

 private:
  static constexpr std::uint32_t kInstructionsPerTick = 5;
  std::array<std::uint8_t, 512> heard_ = {};
};

Pipes pipes;
Mps2 mps2;
hil::HilBoard board(pipes, mps2);
boards::Room room;
std::array<char, 256> command_line = {};

}  // namespace
}  // namespace halfroll::cortex_m

void board_main() {
  using namespace halfroll::cortex_m;
  mps2.words = take_last_words();
  std::array<char*, 5> words = {};
  std::size_t count = 0;
  if (semihosting::command_line(command_line.data(), command_line.size())) {
    for (char* at = command_line.data(); at != nullptr && *at != '\0' && count < words.size();) {
      words[count++] = at;
      at = std::strchr(at, ' ');
      if (at != nullptr) *at++ = '\0';
    }
  }
  constexpr int kNoPipes = 2;
  if (count < 3) semihosting::exit(kNoPipes);
  pipes.open(words[1], words[2]);
  mps2.flash.open(count > 3 ? words[3] : "");
  if (count > 4) mps2.flash.cut_after(static_cast<std::uint32_t>(std::atoi(words[4])));
  uart::start();
  clock::start();
  halfroll::boards::run(board, room);
  semihosting::exit(0);
}
