#include "boards/cortex_m/uart.hpp"

#include "boards/cortex_m/registers.hpp"

namespace halfroll::cortex_m::uart {
namespace {

constexpr std::uint32_t kBaud = 921600, kClock = 25000000;
constexpr std::uint32_t kTransmitterFull = 1, kReceived = 2;  // state
constexpr std::uint32_t kAllOn = 0xF;                         // transmitter, receiver, an interrupt of each
constexpr std::uint32_t kTransmitDone = 1, kReceiveDone = 2;  // interrupt, written to clear
constexpr unsigned kReceiveLine = 0, kTransmitLine = 1;
constexpr std::uint8_t kUrgency = 0xC0;

UartRegisters& registers() { return *reinterpret_cast<UartRegisters*>(0x40004000U); }

/// One writer, one reader, neither of which may wait for the other.
template <std::size_t Size>
struct Ring {
  std::array<std::uint8_t, Size> bytes = {};
  volatile std::size_t head = 0, tail = 0;  // written to, read from; both only grow

  std::size_t used() const { return head - tail; }
  void push(std::uint8_t byte) {
    bytes[head % Size] = byte;
    head = head + 1;
  }
  std::uint8_t pop() {
    const std::uint8_t byte = bytes[tail % Size];
    tail = tail + 1;
    return byte;
  }
};
Ring<1024> received;
Ring<4096> to_send;
volatile bool sending = false;

}  // namespace

void start() {
  registers().divider = kClock / kBaud;
  registers().control = kAllOn;
  for (const unsigned line : {kReceiveLine, kTransmitLine}) {
    nvic::priority(line, kUrgency);
    nvic::enable(line);
  }
}

std::size_t receive(std::uint8_t* into, std::size_t most) {
  std::size_t n = 0;
  while (n < most && received.used() > 0) into[n++] = received.pop();
  return n;
}

bool send(const std::uint8_t* bytes, std::size_t size) {
  if (to_send.bytes.size() - to_send.used() < size) return false;
  for (std::size_t i = 0; i < size; ++i) to_send.push(bytes[i]);
  asm volatile("cpsid i" ::: "memory");
  if (!sending && to_send.used() > 0) {
    sending = true;
    registers().data = to_send.pop();
  }
  asm volatile("cpsie i" ::: "memory");
  return true;
}

}  // namespace halfroll::cortex_m::uart

extern "C" {
void uart_receive_interrupt();
void uart_transmit_interrupt();

void uart_receive_interrupt() {
  using namespace halfroll::cortex_m::uart;
  registers().interrupt = kReceiveDone;
  while ((registers().state & kReceived) != 0) {
    const auto byte = static_cast<std::uint8_t>(registers().data);
    if (received.used() < received.bytes.size()) received.push(byte);  // else lost, as on any radio
  }
}

void uart_transmit_interrupt() {
  using namespace halfroll::cortex_m::uart;
  registers().interrupt = kTransmitDone;
  if ((registers().state & kTransmitterFull) != 0) return;
  if (to_send.used() > 0) {
    registers().data = to_send.pop();
  } else {
    sending = false;
  }
}
}
