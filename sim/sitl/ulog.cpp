#include "sim/sitl/ulog.hpp"

#include <cstring>
#include <stdexcept>

namespace halfroll::sitl {

static_assert(sizeof(float) == 4, "ULog floats have four bytes");

Ulog::Ulog(const std::string& path) : file_(path, std::ios::binary | std::ios::trunc) {
  if (!file_) throw std::runtime_error("--log " + path + " cannot be written");
  const unsigned char header[16] = {'U', 'L', 'o', 'g', 0x01, 0x12, 0x35, 1};  // version 1, begins at time 0
  append(header, sizeof header);
  open_message('B');
  const char no_flags[40] = {};
  append(no_flags, sizeof no_flags);
  close_message();
}

void Ulog::info(const std::string& key, const std::string& text) {
  const std::string typed = "char[" + std::to_string(text.size()) + "] " + key;
  open_message('I');
  put(static_cast<std::uint8_t>(typed.size()));
  append(typed);
  append(text);
  close_message();
}

void Ulog::param(const std::string& id, float initial) {
  const std::string typed = "float " + id;
  open_message('P');
  put(static_cast<std::uint8_t>(typed.size()));
  append(typed);
  put(initial);
  close_message();
}

Ulog::Topic Ulog::add_topic(const std::string& name, const std::string& fields) {
  open_message('F');
  append(name + ":uint64_t timestamp;" + fields);
  close_message();
  topics_.push_back(name);
  return static_cast<Topic>(topics_.size() - 1);
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
  file_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  file_.flush();
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
}

void Ulog::append(const void* bytes, std::size_t size) {
  const auto* from = static_cast<const char*>(bytes);
  buffer_.insert(buffer_.end(), from, from + size);
}

}  // namespace halfroll::sitl
