// Questions that are answered from themselves: TIMESYNC, PING, file transfer. Why: no state, so no class.
#pragma once
#include "link/outbox.hpp"

namespace halfroll::link {

/// Answer a request (tc1 = 0) with our time; a reply to ours is not answered.
void answer(const Timesync& message, const Header& header, std::uint64_t t_us, Outbox& outbox);
/// Answer a PING to everybody.
void answer(const Ping& message, const Header& header, Outbox& outbox);
/// There are no files: NAK, so that clients fall back at once.
void answer(const FileTransfer& message, const Header& header, Outbox& outbox);

}  // namespace halfroll::link
