#include "sim/sitl/on_board.hpp"

#include <algorithm>
#include <bitset>
#include <cstdio>
#include <cstring>

namespace halfroll::sitl {
namespace {

constexpr std::size_t kRequestBytes = 8 * 1024;  // of datagrams in one request

std::uint64_t differing(float a, float b) {
  std::uint32_t x = 0, y = 0;
  std::memcpy(&x, &a, sizeof x);
  std::memcpy(&y, &b, sizeof y);
  return std::bitset<32>(x ^ y).count();
}

/// The next part of what came that fits into one request.
LinkInputs part(const LinkInputs& in, std::size_t first) {
  LinkInputs out = in;
  out.rx = in.rx + first;
  out.rx_count = 0;
  std::size_t bytes = 0;
  while (first + out.rx_count < in.rx_count && out.rx_count < hil::kMostDatagrams - 1) {
    bytes += out.rx[out.rx_count].size;
    if (bytes > kRequestBytes && out.rx_count > 0) break;
    ++out.rx_count;
  }
  return out;
}

}  // namespace

/// The answer's payload is in answer_. False: the board has fallen meanwhile, started again and waits for start().
template <class Body>
bool OnBoard::exchange(hil::Kind kind, const Body& body) {
  request_.clear();
  Sink sink{request_};
  hil::write_frame(sink, kind, body);
  channel_->write(request_.data(), request_.size());
  for (;;) {
    const hil::Kind got = receive();
    if (got == kind) return true;
    if (got == hil::Kind::kHello && kind != hil::Kind::kStart) return false;
  }
}

hil::Kind OnBoard::receive() {
  answer_.clear();
  std::array<std::uint8_t, 4096> piece;
  std::size_t wanted = hil::kHead;
  for (;;) {
    while (answer_.size() < wanted) {  // never beyond this frame: the next one is not ours yet
      const std::size_t got = channel_->read(piece.data(), std::min(piece.size(), wanted - answer_.size()));
      if (got == 0) throw host::BoardLost("the board has ended");
      answer_.insert(answer_.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(got));
    }
    const hil::Head head = hil::read_head(answer_.data());
    wanted = hil::kHead + head.size + hil::kTail;
    if (!head.good || head.size > (1U << 20U)) {
      answer_.erase(answer_.begin());
      wanted = hil::kHead;
    } else if (answer_.size() >= wanted) {
      if (hil::is_whole(answer_.data(), head.size)) return head.kind;
      answer_.erase(answer_.begin());
      wanted = std::max(hil::kHead, answer_.size());
    }
  }
}

void OnBoard::start(const boards::Start& start) {
  exchange(hil::Kind::kStart, [&](auto& writer) { hil::pass_start(writer, start); });
  hil::Reader reader(answer_.data() + hil::kHead, answer_.size() - hil::kHead - hil::kTail);
  hil::pass_params(reader, params_);
  shown_ = {};
  if (beside_) beside_->start(start);
}

Outputs OnBoard::step(const Inputs& in) {
  tx_.clear();
  Outputs out;
  const bool lives =
      exchange(hil::Kind::kStep, [&](auto& writer) { hil::write_turn(writer, hil::Kind::kStep, in, ask_time_); });
  ask_time_ = false;
  if (!lives) {
    out.link.reboot = true;
    return out;
  }
  hil::Reader reader(answer_.data() + hil::kHead, answer_.size() - hil::kHead - hil::kTail);
  reader(out.rotors);
  read_links(reader);
  out.link = links();
  ++steps_;
  instructions_.push_back(shown_.instructions);
  if (beside_) {
    const Outputs here = beside_->step(in);
    compare(out.rotors, here.rotors);
    compare(here.link, 0);
  }
  return out;
}

LinkOutputs OnBoard::service(const LinkInputs& in) {
  tx_.clear();
  std::size_t done = 0;
  do {
    Inputs some;
    some.link = part(in, done);
    done += some.link.rx_count;
    const std::size_t first = tx_.size();
    const bool lives = exchange(hil::Kind::kService,
                                [&](auto& writer) { hil::write_turn(writer, hil::Kind::kService, some, ask_time_); });
    ask_time_ = false;
    if (!lives) {
      LinkOutputs fallen;
      fallen.reboot = true;
      return fallen;
    }
    hil::Reader reader(answer_.data() + hil::kHead, answer_.size() - hil::kHead - hil::kTail);
    read_links(reader);
    if (beside_) compare(beside_->service(some.link), first);
  } while (done < in.rx_count);
  return links();
}

void OnBoard::ask_time() {
  ask_time_ = true;
  if (beside_) beside_->ask_time();
}

void OnBoard::read_links(hil::Reader& reader) {
  std::uint16_t count = 0;
  reader(shown_, count);
  for (int i = 0; i < count; ++i) {
    link::TxFrame frame;
    reader(frame.to.link, frame.to.slot, frame.size);
    if (frame.size > frame.bytes.size()) return;
    if (const std::uint8_t* bytes = reader.bytes(frame.size)) std::memcpy(frame.bytes.data(), bytes, frame.size);
    tx_.push_back(frame);
  }
}

LinkOutputs OnBoard::links() const {
  LinkOutputs out;
  out.tx = tx_.data();
  out.tx_count = tx_.size();
  out.shut_down = shown_.shut_down;
  out.reboot = shown_.reboot;
  return out;
}

void OnBoard::compare(const RotorCommands& board, const RotorCommands& here) {
  for (std::size_t i = 0; i < board.thrust.size(); ++i) differing_bits_ += differing(board.thrust[i], here.thrust[i]);
  differing_bits_ += std::bitset<32>(shown_.state_checksum ^ beside_->state_checksum()).count();
}

void OnBoard::compare(const LinkOutputs& here, std::size_t first) {
  const std::size_t count = std::max(here.tx_count, tx_.size() - first);
  for (std::size_t i = 0; i < count; ++i) {
    const bool both = i < here.tx_count && first + i < tx_.size();
    const bool same =
        both && here.tx[i].size == tx_[first + i].size && here.tx[i].to == tx_[first + i].to &&
        std::equal(here.tx[i].bytes.begin(), here.tx[i].bytes.begin() + here.tx[i].size, tx_[first + i].bytes.begin());
    if (!same) ++differing_frames_;
  }
}

std::string OnBoard::finish() {
  hil::Totals totals;
  if (exchange(hil::Kind::kEnd, [](auto&) {})) {
    hil::Reader(answer_.data() + hil::kHead, answer_.size() - hil::kHead - hil::kTail)(totals);
  }
  std::sort(instructions_.begin(), instructions_.end());
  const auto quantile = [&](double share) -> std::uint32_t {
    if (instructions_.empty()) return 0;
    return instructions_[static_cast<std::size_t>(share * static_cast<double>(instructions_.size() - 1))];
  };
  std::array<char, 400> line{};
  std::snprintf(line.data(), line.size(),
                "{\"steps\": %llu, \"compared\": %s, \"differing_bits\": %llu, \"differing_frames\": %llu, "
                "\"median_instructions\": %u, \"p999_instructions\": %u, \"worst_instructions\": %u, "
                "\"stack_bytes\": %u, \"late_steps\": %u}",
                static_cast<unsigned long long>(steps_), beside_ ? "true" : "false",
                static_cast<unsigned long long>(differing_bits_), static_cast<unsigned long long>(differing_frames_),
                quantile(0.5), quantile(0.999), quantile(1.0), totals.stack_bytes, totals.late_steps);
  return line.data();
}

}  // namespace halfroll::sitl
