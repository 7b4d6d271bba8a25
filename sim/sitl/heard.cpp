#include "sim/sitl/heard.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "sim/sitl/bad_option.hpp"

namespace halfroll::sitl {
namespace {

constexpr std::size_t kPiece = 48;  // bytes of a datagram in one record
constexpr const char* kCalls = "firmware_call";
constexpr const char* kDatagrams = "link_input";
constexpr const char* kImages = "stored_image";
constexpr const char* kSteps = "rotor_commands";  // logged once a step

/// The next number of a record; what is too short gives 0, and pyulog calls it damaged.
template <class Number>
Number take(const char*& from, const char* end) {
  Number x = 0;
  if (end - from >= static_cast<std::ptrdiff_t>(sizeof x)) std::memcpy(&x, from, sizeof x);
  from += sizeof x;
  return x;
}

}  // namespace

HeardLog::HeardLog(Ulog& ulog) : ulog_(ulog) {
  const std::string pieces = "uint8_t size;uint8_t[" + std::to_string(kPiece) + "] bytes;";
  calls_ = ulog.add_topic(kCalls, "uint64_t wall_us;uint8_t call;");
  datagrams_ = ulog.add_topic(kDatagrams, "uint32_t left;uint8_t link;uint8_t slot;" + pieces);
  images_ = ulog.add_topic(kImages, "uint32_t left;uint8_t slot;uint8_t state;" + pieces);
}

void HeardLog::image(std::uint64_t t_us, link::StorageSlot slot, const link::StoredImage& image) {
  if (image.state == link::StoredState::kNothing) return;
  pieces(images_, t_us, static_cast<std::uint8_t>(slot), static_cast<std::uint8_t>(image.state), image.bytes,
         image.size);
}

void HeardLog::start(std::uint64_t t_us, std::uint64_t unix_us_at_wall_0) {
  end(t_us, Call::kStart, unix_us_at_wall_0);
}

void HeardLog::call(std::uint64_t t_us, Call call, const LinkInputs& in) {
  if (call == Call::kStep && in.rx_count == 0 && in.wall_us == wall_us_) return;
  wall_us_ = in.wall_us;
  for (std::size_t i = 0; i < in.rx_count; ++i) {
    const link::Datagram& datagram = in.rx[i];
    pieces(datagrams_, t_us, datagram.from.link, datagram.from.slot, datagram.bytes, datagram.size);
  }
  end(t_us, call, in.wall_us);
}

void HeardLog::ask_time(std::uint64_t t_us) { end(t_us, Call::kAskTime, wall_us_); }

void HeardLog::pieces(Ulog::Topic topic, std::uint64_t t_us, std::uint8_t first, std::uint8_t second,
                      const std::uint8_t* bytes, std::size_t size) {
  constexpr std::array<std::uint8_t, kPiece> kNothing = {};
  std::size_t left = size;
  do {
    const std::size_t now = std::min(left, kPiece);
    left -= now;
    ulog_.begin(topic, t_us);
    ulog_.put(static_cast<std::uint32_t>(left));
    ulog_.put(first);
    ulog_.put(second);
    ulog_.put(static_cast<std::uint8_t>(now));
    ulog_.put_bytes(bytes, now);
    ulog_.put_bytes(kNothing.data(), kPiece - now);
    ulog_.end();
    bytes += now;
  } while (left > 0);
}

void HeardLog::end(std::uint64_t t_us, Call call, std::uint64_t wall_us) {
  ulog_.begin(calls_, t_us);
  ulog_.put(wall_us);
  ulog_.put(static_cast<std::uint8_t>(call));
  ulog_.end();
}

HeardReader::HeardReader(const std::string& path) : path_(path), file_(path, std::ios::binary) {
  char header[16] = {};
  if (!file_) throw BadOption("--replay " + path + " cannot be read");
  if (!file_.read(header, sizeof header) || std::memcmp(header, "ULog", 4) != 0) {
    throw BadOption("--replay " + path + " is no flight log");
  }
  while ((first_ = read()) && first_->type != 'D') {
    if (first_->type == 'A') subscribe(first_->body);
    if (first_->type != 'I' || first_->body.empty()) continue;
    const std::size_t size = static_cast<std::uint8_t>(first_->body[0]);
    const std::string key = first_->body.substr(1, size);
    if (first_->body.size() > size) info_[key.substr(key.find(' ') + 1)] = first_->body.substr(1 + size);
  }
  if (calls_ < 0 || info_.count("sitl_arguments") == 0) {
    throw BadOption("--replay " + path + ": what its firmware heard is not in it, so it cannot be flown again");
  }
}

const std::string& HeardReader::info(const std::string& key) const {
  const auto found = info_.find(key);
  if (found == info_.end()) throw BadOption("--replay " + path_ + " has no " + key);
  return found->second;
}

std::optional<Heard> HeardReader::next() {
  Heard heard;
  bool begun = false;  // a datagram, or an image, whose rest follows
  while (auto message = first_ ? std::exchange(first_, std::nullopt) : read()) {
    if (message->type == 'A') subscribe(message->body);
    if (message->type != 'D') continue;
    const char* from = message->body.data();
    const char* const end = from + message->body.size();
    const int topic = take<std::uint16_t>(from, end);
    const auto t_us = take<std::uint64_t>(from, end);
    if (topic == commands_) last_step_us_ = t_us;
    if (topic == calls_) {
      heard.t_us = t_us;
      heard.wall_us = take<std::uint64_t>(from, end);
      heard.call = static_cast<Call>(take<std::uint8_t>(from, end));
      return heard;
    }
    if (topic != datagrams_ && topic != images_) continue;
    const auto left = take<std::uint32_t>(from, end);
    const auto one = take<std::uint8_t>(from, end), two = take<std::uint8_t>(from, end);
    const std::size_t size = take<std::uint8_t>(from, end);
    if (size > kPiece || end - from < static_cast<std::ptrdiff_t>(size)) return std::nullopt;
    if (!begun && topic == datagrams_) heard.datagrams.push_back({{one, two}, {}});
    if (!begun && topic == images_) {
      heard.images.push_back({static_cast<link::StorageSlot>(one), static_cast<link::StoredState>(two), {}});
    }
    auto& bytes = topic == datagrams_ ? heard.datagrams.back().bytes : heard.images.back().bytes;
    bytes.insert(bytes.end(), from, from + size);
    begun = left > 0;
  }
  return std::nullopt;
}

std::optional<HeardReader::Message> HeardReader::read() {
  char head[3] = {};
  if (!file_.read(head, sizeof head)) return std::nullopt;
  std::uint16_t size = 0;
  std::memcpy(&size, head, sizeof size);
  Message message{head[2], std::string(size, '\0')};
  if (!file_.read(message.body.data(), size)) return std::nullopt;
  return message;
}

void HeardReader::subscribe(const std::string& body) {
  if (body.size() < 3) return;
  std::uint16_t topic = 0;
  std::memcpy(&topic, body.data() + 1, sizeof topic);
  const std::string name = body.substr(3);
  if (name == kCalls) calls_ = topic;
  if (name == kDatagrams) datagrams_ = topic;
  if (name == kImages) images_ = topic;
  if (name == kSteps) commands_ = topic;
}

}  // namespace halfroll::sitl
