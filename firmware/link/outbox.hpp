// Frames on their way out. Why: one bounded place that numbers frames per link and forgets nothing silently.
#pragma once
#include <algorithm>

#include "link/codec.hpp"
#include "link/status_text.hpp"

namespace halfroll::link {

class Outbox {
 public:
  static constexpr std::size_t kCapacity = 192;

  /// Start of a step or service call: what was there has been taken.
  void begin(std::uint8_t own_system, std::uint64_t t_us) {
    system_ = own_system;
    t_us_ = t_us;
    size_ = 0;
  }

  /// To one endpoint, to all of a link (slot kEveryone) or to all links.
  template <class M>
  void send(Endpoint to, const M& message) {
    for (int link = 0; link < kLinkCount; ++link) {
      if (to.link != kAllLinks && to.link != link) continue;
      if (size_ == kCapacity) {
        ++overflows_;
        continue;
      }
      std::uint8_t& sequence = sequence_[static_cast<std::size_t>(link)];
      const TxFrame frame = encode(message, Envelope{system_, sequence});
      if (frame.size == 0) continue;
      ++sequence;
      TxFrame& kept = frames_[size_++];
      kept.to = {static_cast<std::uint8_t>(link), to.slot};
      kept.size = frame.size;
      std::copy_n(frame.bytes.begin(), frame.size, kept.bytes.begin());  // mostly a tenth of them
    }
  }

  /// STATUSTEXT to all, within the limits on texts.
  void say(Severity severity, const Text<50>& text) {
    if (limit_.allows(text, t_us_)) send(kToAll, StatusText{severity, text});
  }

  TxFrame* frames() { return frames_.data(); }
  const TxFrame* frames() const { return frames_.data(); }
  std::size_t size() const { return size_; }
  std::uint32_t overflows() const { return overflows_; }
  std::uint64_t t_us() const { return t_us_; }
  auto state() const { return std::tuple_cat(std::tie(sequence_, overflows_), limit_.state()); }

 private:
  std::array<TxFrame, kCapacity> frames_ = {};
  std::size_t size_ = 0;
  std::array<std::uint8_t, kLinkCount> sequence_ = {};
  std::uint32_t overflows_ = 0;
  std::uint64_t t_us_ = 0;
  std::uint8_t system_ = 1;
  TextLimit limit_;
};

}  // namespace halfroll::link
