#include "boards/host/udp_links.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace halfroll::host {
namespace {

sockaddr_in to_sockaddr(std::uint32_t address, std::uint16_t port) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_addr.s_addr = address;
  a.sin_port = port;
  return a;
}

/// Starts with a whole MAVLink 1 or 2 frame, as far as start byte and length tell.
bool well_formed(const std::uint8_t* bytes, std::size_t size) {
  if (size < 8) return false;
  const std::size_t payload = bytes[1];
  if (bytes[0] == 0xFE) return size >= payload + 8;
  return bytes[0] == 0xFD && size >= payload + 12;
}

bool is_for(const link::TxFrame& frame, std::size_t link, std::size_t slot) {
  return (frame.to.link == link::kAllLinks || frame.to.link == link) &&
         (frame.to.slot == link::kEveryone || frame.to.slot == slot);
}

}  // namespace

PortInUse::PortInUse(std::uint16_t taken)
    : std::runtime_error("UDP port " + std::to_string(taken) + " is in use"), port(taken) {}

UdpLinks::UdpLinks(const std::string& bind_address, const std::array<UdpPorts, link::kLinkCount>& ports)
    : buffers_(kAtOnce * link::kLinkCount) {
  try {
    for (std::size_t i = 0; i < links_.size(); ++i) open(links_[i], bind_address, ports[i]);
  } catch (...) {
    close_all();
    throw;
  }
}

UdpLinks::~UdpLinks() { close_all(); }

void UdpLinks::close_all() {
  for (Link& link : links_) {
    if (link.socket >= 0) ::close(link.socket);
  }
}

void UdpLinks::open(Link& link, const std::string& bind_address, UdpPorts ports) {
  in_addr address{};
  if (inet_pton(AF_INET, bind_address.c_str(), &address) != 1) {
    throw std::runtime_error("--bind " + bind_address + " is not an IPv4 address such as 127.0.0.1");
  }
  link.socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (link.socket < 0) throw std::runtime_error(std::string("cannot open a UDP socket: ") + std::strerror(errno));
  const sockaddr_in ours = to_sockaddr(address.s_addr, htons(ports.bind));
  if (::bind(link.socket, reinterpret_cast<const sockaddr*>(&ours), sizeof ours) != 0) {
    if (errno == EADDRINUSE) throw PortInUse(ports.bind);
    throw std::runtime_error("cannot bind UDP " + bind_address + " port " + std::to_string(ports.bind) + ": " +
                             std::strerror(errno));
  }
  link.peers[0] = {htonl(INADDR_LOOPBACK), htons(ports.peer), 0};
}

const std::vector<link::Datagram>& UdpLinks::receive(std::uint64_t wall_us, std::size_t most, std::size_t most_bytes) {
  received_.clear();
  for (Link& link : links_) {
    for (std::size_t slot = 1; slot < kSlots; ++slot) {
      if (link.peers[slot].address != 0 && wall_us - link.peers[slot].heard_us > kForgetUs) link.peers[slot] = Peer{};
    }
  }
  const std::array<bool, link::kLinkCount> something = wait(0);  // one question to the system in place of three
  for (std::uint8_t i = 0; i < link::kLinkCount; ++i) {
    if (something[i]) drain(i, wall_us, most, most_bytes);
  }
  return received_;
}

void UdpLinks::drain(std::uint8_t index, std::uint64_t wall_us, std::size_t most, std::size_t most_bytes) {
  Link& link = links_[index];
  std::size_t bytes = 0;
  for (std::size_t n = 0; n < most && bytes < most_bytes; ++n) {
    auto& buffer = buffers_[index * kAtOnce + n];
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t size =
        ::recvfrom(link.socket, buffer.data(), buffer.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (size < 0) return;
    bytes += static_cast<std::size_t>(size);
    const int slot =
        slot_of(link, {from.sin_addr.s_addr, from.sin_port, wall_us}, buffer.data(), static_cast<std::size_t>(size));
    if (slot < 0) continue;
    received_.push_back({{index, static_cast<std::uint8_t>(slot)}, buffer.data(), static_cast<std::size_t>(size)});
  }
}

/// The sender's slot, a free one if it is new, or -1: not MAVLink, or no slot left.
int UdpLinks::slot_of(Link& link, Peer sender, const std::uint8_t* bytes, std::size_t size) {
  int free_slot = -1;
  for (std::size_t slot = 0; slot < kSlots; ++slot) {
    Peer& peer = link.peers[slot];
    if (peer.address == sender.address && peer.port == sender.port) {
      peer.heard_us = sender.heard_us;
      return static_cast<int>(slot);
    }
    if (free_slot < 0 && peer.address == 0) free_slot = static_cast<int>(slot);
  }
  if (free_slot < 0 || !well_formed(bytes, size)) return -1;
  link.peers[static_cast<std::size_t>(free_slot)] = sender;
  return free_slot;
}

std::array<bool, link::kLinkCount> UdpLinks::wait(int ms) const {
  std::array<pollfd, link::kLinkCount> sockets{};
  for (std::size_t i = 0; i < sockets.size(); ++i) sockets[i] = {links_[i].socket, POLLIN, 0};
  ::poll(sockets.data(), sockets.size(), ms);
  std::array<bool, link::kLinkCount> something{};
  for (std::size_t i = 0; i < sockets.size(); ++i) something[i] = sockets[i].revents != 0;
  return something;
}

void UdpLinks::send(const link::TxFrame& frame) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      if (is_for(frame, i, slot)) send_to(links_[i], links_[i].peers[slot], frame.bytes.data(), frame.size);
    }
  }
}

void UdpLinks::send(const std::vector<link::TxFrame>& frames) {
  std::array<std::uint8_t, kPacked> packed;
  for (std::size_t links_left = links_.size(); links_left > 0; --links_left) {
    const std::size_t i = links_left - 1;
    for (std::size_t slots_left = kSlots; slots_left > 0; --slots_left) {
      const std::size_t slot = slots_left - 1;
      const Peer& peer = links_[i].peers[slot];
      if (peer.address == 0) continue;
      std::size_t size = 0;
      for (const link::TxFrame& frame : frames) {
        if (!is_for(frame, i, slot)) continue;
        if (size + frame.size > kPacked) {
          send_to(links_[i], peer, packed.data(), size);
          size = 0;
        }
        std::copy_n(frame.bytes.begin(), frame.size, packed.begin() + static_cast<std::ptrdiff_t>(size));
        size += frame.size;
      }
      if (size > 0) send_to(links_[i], peer, packed.data(), size);
    }
  }
}

void UdpLinks::send_to(const Link& link, const Peer& peer, const std::uint8_t* bytes, std::size_t size) {
  if (peer.address == 0) return;
  const sockaddr_in to = to_sockaddr(peer.address, peer.port);
  static_cast<void>(::sendto(link.socket, bytes, size, 0, reinterpret_cast<const sockaddr*>(&to), sizeof to));
}

}  // namespace halfroll::host
