// Counting what comes over a link, by the sequence numbers of whoever speaks there.
#pragma once
#include <array>

#include "link/codec.hpp"
#include "link/link_totals.hpp"

namespace halfroll::link {

class LinkCounters {
 public:
  void received(const Received& received) {
    ++totals_.received;
    Sender& sender = senders_[received.header.from.slot % senders_.size()];
    const auto missing = static_cast<std::uint8_t>(received.sequence - sender.sequence - 1U);
    const bool goes_on = sender.known && sender.address == received.header.sender;
    if (goes_on && missing < kReordered) totals_.lost += missing;
    sender = {received.header.sender, received.sequence, true};
  }
  void bad(std::uint32_t frames) { totals_.bad += frames; }
  void refused() { ++totals_.refused; }
  void passed_over(std::size_t bytes) { totals_.passed_over += static_cast<std::uint32_t>(bytes); }

  const LinkTotals& totals() const { return totals_; }

 private:
  static constexpr std::uint8_t kReordered = 128;  // so many missing are one that came late or twice

  struct Sender {
    Address address;
    std::uint8_t sequence = 0;
    bool known = false;
  };
  LinkTotals totals_;
  std::array<Sender, 9> senders_ = {};  // by slot: who spoke last there
};

}  // namespace halfroll::link
