// MAVLink by serial line: CMSDK UART 0, both directions by interrupt, a ring buffer each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace halfroll::cortex_m::uart {

void start();

/// Bytes received so far, at most as many as fit: returns how many.
std::size_t receive(std::uint8_t* into, std::size_t most);
/// All of them, or none where the buffer is full: half a frame is no frame.
bool send(const std::uint8_t* bytes, std::size_t size);

}  // namespace halfroll::cortex_m::uart
