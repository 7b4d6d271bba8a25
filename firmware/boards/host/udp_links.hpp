// UDP sockets as the firmware's links. Why: the firmware numbers endpoints; addresses live and die here.
//
// Slot 0 of a link is its default peer on loopback. Whoever sends a well-formed frame gets one of slots 1..8 until it
// has been silent for 30 s; a ninth is not heard. Well-formed means start byte and length; the firmware checks the CRC.
#pragma once
#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include "link/datagram.hpp"

namespace halfroll::host {

struct UdpPorts {
  std::uint16_t bind = 0;  // ours
  std::uint16_t peer = 0;  // of the default peer on 127.0.0.1
};

/// The port is somebody else's.
struct PortInUse : std::runtime_error {
  explicit PortInUse(std::uint16_t taken);
  std::uint16_t port;
};

class UdpLinks {
 public:
  static constexpr std::size_t kAtOnce = 64;     // datagrams of a link in one receive()
  static constexpr std::size_t kLongest = 2048;  // bytes

  /// Bind all sockets. Throws PortInUse; std::runtime_error for an address that is not this machine's.
  UdpLinks(const std::string& bind_address, const std::array<UdpPorts, link::kLinkCount>& ports);
  UdpLinks(const UdpLinks&) = delete;
  UdpLinks& operator=(const UdpLinks&) = delete;
  ~UdpLinks();

  /// What has arrived, link A first, in order of arrival; valid until the next call. Never waits. Of each link at most
  /// `most` datagrams, and none more once they are `most_bytes` together: the rest waits in the socket.
  const std::vector<link::Datagram>& receive(std::uint64_t wall_us, std::size_t most = kAtOnce,
                                             std::size_t most_bytes = kAtOnce * kLongest);

  /// Wait until something arrives, a signal comes or `ms` have passed: which links have something.
  std::array<bool, link::kLinkCount> wait(int ms) const;

  /// Send to one endpoint or to all; what cannot be sent is lost, as on any radio.
  void send(const link::TxFrame& frame);
  /// The same of several, in as few datagrams as they fit in; order is kept for each peer, and the first peer of
  /// the first link comes last: a question that ends it comes when all has been said.
  void send(const std::vector<link::TxFrame>& frames);

 private:
  static constexpr std::size_t kSlots = 9;
  static constexpr std::size_t kPacked = 1200;  // bytes that pass any network whole
  static constexpr std::uint64_t kForgetUs = 30000000;

  struct Peer {
    std::uint32_t address = 0;  // network order; 0 is nobody
    std::uint16_t port = 0;     // network order
    std::uint64_t heard_us = 0;
  };
  struct Link {
    int socket = -1;
    std::array<Peer, kSlots> peers = {};
  };

  void open(Link& link, const std::string& bind_address, UdpPorts ports);
  void close_all();
  void drain(std::uint8_t index, std::uint64_t wall_us, std::size_t most, std::size_t most_bytes);
  static int slot_of(Link& link, Peer sender, const std::uint8_t* bytes, std::size_t size);
  static void send_to(const Link& link, const Peer& peer, const std::uint8_t* bytes, std::size_t size);

  std::array<Link, link::kLinkCount> links_;
  std::vector<std::array<std::uint8_t, kLongest>> buffers_;
  std::vector<link::Datagram> received_;
};

}  // namespace halfroll::host
