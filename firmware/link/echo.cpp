#include "link/echo.hpp"

namespace halfroll::link {

void answer(const Timesync& message, const Header& header, std::uint64_t t_us, Outbox& outbox) {
  if (message.tc1 != 0) return;
  const auto now_ns = static_cast<std::int64_t>(t_us) * 1000;
  outbox.send(header.from, Timesync{now_ns == 0 ? 1 : now_ns, message.ts1});
}

void answer(const Ping& message, const Header& header, Outbox& outbox) {
  if (!(message.target == Address{})) return;  // an answer to somebody's question
  outbox.send(header.from, Ping{header.sender, message.time_us, message.seq});
}

void answer(const FileTransfer& message, const Header& header, Outbox& outbox) {
  constexpr std::size_t kSequence = 0, kSession = 2, kOpcode = 3, kSize = 4, kRequestOpcode = 5, kData = 12;
  constexpr std::uint8_t kTerminateSession = 1, kResetSessions = 2, kListDirectory = 3, kOpenFile = 4, kAck = 128,
                         kNak = 129, kUnknownCommand = 7, kFileNotFound = 10;
  const std::uint8_t asked = message.payload[kOpcode];
  const bool closing = asked == kTerminateSession || asked == kResetSessions;
  const bool opening = asked == kListDirectory || asked == kOpenFile;
  const unsigned sequence = message.payload[kSequence] + 256U * message.payload[kSequence + 1] + 1U;
  FileTransfer reply;
  reply.target = header.sender;
  reply.payload[kSequence] = static_cast<std::uint8_t>(sequence & 0xFFU);
  reply.payload[kSequence + 1] = static_cast<std::uint8_t>((sequence >> 8U) & 0xFFU);
  reply.payload[kSession] = message.payload[kSession];
  reply.payload[kOpcode] = closing ? kAck : kNak;
  reply.payload[kSize] = closing ? 0 : 1;
  reply.payload[kRequestOpcode] = asked;
  if (!closing) reply.payload[kData] = opening ? kFileNotFound : kUnknownCommand;
  outbox.send(header.from, reply);
}

}  // namespace halfroll::link
