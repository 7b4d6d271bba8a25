// Bytes to a board: a program's standard input and output, or a serial port.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <stdexcept>
#include <string>

#include "boards/hil/hil_board.hpp"

namespace halfroll::host {

/// The board at the other end is gone, or silent.
struct BoardLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class ByteChannel final : public hil::Channel {
 public:
  /// Descriptors that somebody else closes; read() waits for ever.
  ByteChannel(int in, int out) : in_(in), out_(out) {}
  ByteChannel(const ByteChannel&) = delete;
  ByteChannel& operator=(const ByteChannel&) = delete;
  ~ByteChannel();

  /// Start a program by the shell, in a directory ("": one of its own, removed afterwards). It ends when we do.
  ByteChannel(const std::string& command, const std::string& directory);
  /// Open DEVICE or DEVICE:BAUD. Throws std::runtime_error.
  explicit ByteChannel(const std::string& port);

  std::size_t read(std::uint8_t* into, std::size_t most) override;
  void write(const std::uint8_t* bytes, std::size_t size) override;

 private:
  int in_ = -1, out_ = -1;
  pid_t child_ = -1;
  bool ours_ = false;
  std::string directory_;  // to be removed
};

}  // namespace halfroll::host
