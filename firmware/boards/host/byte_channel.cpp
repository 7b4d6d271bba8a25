#include "boards/host/byte_channel.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

namespace halfroll::host {
namespace {

constexpr int kSilentMs = 20000;  // a board, or an emulator on a busy machine, answers long before

speed_t speed_of(const std::string& baud) {
  constexpr std::array<std::pair<const char*, speed_t>, 8> kSpeeds = {{{"115200", B115200},
                                                                       {"230400", B230400},
                                                                       {"460800", B460800},
                                                                       {"921600", B921600},
                                                                       {"1000000", B1000000},
                                                                       {"2000000", B2000000},
                                                                       {"3000000", B3000000},
                                                                       {"4000000", B4000000}}};
  for (const auto& [name, speed] : kSpeeds) {
    if (baud == name) return speed;
  }
  throw std::runtime_error("baud rate " + baud + " is not one of 115200, 230400, 460800, 921600, 1000000 to 4000000");
}

[[noreturn]] void become(const std::string& command, const std::string& directory, int in, int out) {
  ::setpgid(0, 0);  // Ctrl-C is for us: we end it properly
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::dup2(in, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  if (::chdir(directory.c_str()) == 0) ::execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), nullptr);
  ::_exit(127);
}

}  // namespace

ByteChannel::ByteChannel(const std::string& command, const std::string& directory) : ours_(true) {
  std::string folder = directory;
  if (folder.empty()) {
    std::string made = (std::filesystem::temp_directory_path() / "halfroll-board-XXXXXX").string();
    if (::mkdtemp(made.data()) == nullptr) throw std::runtime_error("cannot make a directory for the board");
    folder = directory_ = made;
  }
  std::filesystem::create_directories(folder);
  std::array<int, 2> to{}, from{};
  if (::pipe2(to.data(), O_CLOEXEC) != 0 || ::pipe2(from.data(), O_CLOEXEC) != 0) {
    throw std::runtime_error(std::string("cannot make a pipe: ") + std::strerror(errno));
  }
  ::signal(SIGPIPE, SIG_IGN);
  child_ = ::fork();
  if (child_ < 0) throw std::runtime_error(std::string("cannot start the board: ") + std::strerror(errno));
  if (child_ == 0) become(command, folder, to[0], from[1]);
  ::close(to[0]);
  ::close(from[1]);
  in_ = from[0];
  out_ = to[1];
}

ByteChannel::ByteChannel(const std::string& port) : ours_(true) {
  const std::size_t colon = port.rfind(':');
  const std::string device = port.substr(0, colon);
  const speed_t speed = speed_of(colon == std::string::npos ? "921600" : port.substr(colon + 1));
  in_ = out_ = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  if (in_ < 0 || ::tcgetattr(in_, &settings) != 0) {
    throw std::runtime_error("serial port " + device + " cannot be opened: " + std::strerror(errno));
  }
  ::cfmakeraw(&settings);
  ::cfsetspeed(&settings, speed);
  settings.c_cflag |= CLOCAL | CREAD;
  ::tcsetattr(in_, TCSANOW, &settings);
  ::tcflush(in_, TCIOFLUSH);
}

ByteChannel::~ByteChannel() {
  if (!ours_) return;
  ::close(out_);
  if (in_ != out_) ::close(in_);
  if (child_ > 0) {
    ::kill(child_, SIGTERM);
    ::waitpid(child_, nullptr, 0);
  }
  std::error_code ignored;
  if (!directory_.empty()) std::filesystem::remove_all(directory_, ignored);
}

std::size_t ByteChannel::read(std::uint8_t* into, std::size_t most) {
  for (;;) {
    if (ours_) {
      pollfd waiting{in_, POLLIN, 0};
      const int ready = ::poll(&waiting, 1, kSilentMs);
      if (ready == 0) throw BoardLost("the board has not answered for 20 s");
      if (ready < 0 && errno == EINTR) continue;
    }
    const ssize_t got = ::read(in_, into, most);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR) return 0;
  }
}

void ByteChannel::write(const std::uint8_t* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(out_, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // the next read() says that it is gone
    bytes += written;
    size -= static_cast<std::size_t>(written);
  }
}

}  // namespace halfroll::host
