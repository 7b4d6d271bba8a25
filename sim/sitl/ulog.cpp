#include "sim/sitl/ulog.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace halfroll::sitl {

static_assert(sizeof(float) == 4, "ULog floats have four bytes");

Ulog::Ulog(const std::string& path)
    : file_(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644)) {
  if (file_ < 0) throw std::runtime_error("--log " + path + " cannot be written: " + std::strerror(errno));
  buffer_.reserve(2 * kLargest);
  const unsigned char header[16] = {'U', 'L', 'o', 'g', 0x01, 0x12, 0x35, 1};  // version 1, begins at time 0
  append(header, sizeof header);
  open_message('B');
  const char no_flags[40] = {};
  append(no_flags, sizeof no_flags);
  close_message();
}

Ulog::~Ulog() {
  flush();
  ::close(file_);
}

void Ulog::info(const std::string& key, const std::string& text) {
  typed('I', "char[" + std::to_string(text.size()) + "] " + key, text.data(), text.size());
}
void Ulog::info(const std::string& key, std::int32_t number) { typed('I', "int32_t " + key, &number, sizeof number); }
void Ulog::info(const std::string& key, float number) { typed('I', "float " + key, &number, sizeof number); }
void Ulog::param(const std::string& id, float initial) { typed('P', "float " + id, &initial, sizeof initial); }
void Ulog::param(const std::string& id, std::int32_t initial) { typed('P', "int32_t " + id, &initial, sizeof initial); }

void Ulog::typed(char type, const std::string& type_and_key, const void* value, std::size_t size) {
  open_message(type);
  put(static_cast<std::uint8_t>(type_and_key.size()));
  append(type_and_key);
  append(value, size);
  close_message();
}

Ulog::Topic Ulog::add_topic(const std::string& name, const std::string& fields) {
  announce(name, fields);
  topics_.push_back(name);
  return static_cast<Topic>(topics_.size() - 1);
}

void Ulog::announce(const std::string& name, const std::string& fields) {
  open_message('F');
  append(name + ":uint64_t timestamp;" + fields);
  close_message();
}

void Ulog::begin_data() {
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    const auto topic = static_cast<Topic>(i);
    open_message('A');
    put(std::uint8_t{0});  // first instance
    append(&topic, sizeof topic);
    append(topics_[i]);
    close_message();
  }
  flush();
}

void Ulog::begin(Topic topic, std::uint64_t t_us) {
  open_message('D');
  append(&topic, sizeof topic);
  append(&t_us, sizeof t_us);
}

void Ulog::end() { close_message(); }

void Ulog::text(std::uint8_t severity, std::uint64_t t_us, const std::string& line) {
  open_message('L');
  put(static_cast<std::uint8_t>('0' + severity));
  append(&t_us, sizeof t_us);
  append(line);
  close_message();
}

void Ulog::flush() {
  const char* from = buffer_.data();
  for (std::size_t left = buffer_.size(); left > 0;) {
    const ssize_t written = ::write(file_, from, left);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      good_ = false;
      break;
    }
    from += written;
    left -= static_cast<std::size_t>(written);
  }
  buffer_.clear();
}

void Ulog::open_message(char type) {
  message_ = buffer_.size();
  const char head[3] = {0, 0, type};  // size is filled in at the end
  append(head, sizeof head);
}

void Ulog::close_message() {
  const auto size = static_cast<std::uint16_t>(buffer_.size() - message_ - 3);
  std::memcpy(buffer_.data() + message_, &size, sizeof size);
  if (buffer_.size() > kLargest) flush();
}

void Ulog::append(const void* bytes, std::size_t size) {
  const auto* from = static_cast<const char*>(bytes);
  buffer_.insert(buffer_.end(), from, from + size);
}

}  // namespace halfroll::sitl
