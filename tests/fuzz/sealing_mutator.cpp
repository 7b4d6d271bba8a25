// libFuzzer's hook for targets whose input is a MAVLink stream: messages are added, taken, doubled, moved and changed,
// and the checksums made right again. One change in eight leaves them as they fall.
#include <cstring>
#include <limits>
#include <random>

#include "frames.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace {

using namespace halfroll::fuzz;

constexpr std::uint32_t kHeard[] = {0,  2,  4,  11, 20, 21, 23, 37, 38, 39,  40,  41,  43,  44,  45,  47,
                                    48, 51, 66, 73, 75, 76, 82, 84, 86, 102, 110, 111, 138, 253, 256, 331};
constexpr float kExtremes[] = {0.F,
                               -0.F,
                               1.F,
                               -1.F,
                               1e-40F,  // denormal
                               1e30F,
                               -1e30F,
                               std::numeric_limits<float>::max(),
                               std::numeric_limits<float>::infinity(),
                               -std::numeric_limits<float>::infinity(),
                               std::numeric_limits<float>::quiet_NaN()};

template <class Array>
auto any_of(const Array& array, std::mt19937& random) {
  return array[random() % std::size(array)];
}

void change_payload(Bytes& frame, std::mt19937& random) {
  Bytes payload(frame.begin() + kHeader, frame.end() - 2);
  if (random() % 3 == 0 && payload.size() >= 4) {
    const float value = any_of(kExtremes, random);
    std::memcpy(&payload[random() % (payload.size() / 4) * 4], &value, sizeof value);
  } else {
    const std::size_t size = payload.size();
    payload.resize(255);
    payload.resize(LLVMFuzzerMutate(payload.data(), size, payload.size()));
  }
  frame.resize(kHeader);
  frame.insert(frame.end(), payload.begin(), payload.end());
  frame.resize(std::max<std::size_t>(frame.size(), kHeader + 1) + 2);
  seal(frame);
}

Bytes made_up(std::mt19937& random) {
  const std::uint32_t id = any_of(kHeard, random);
  Bytes payload(mavlink_get_msg_entry(id)->max_msg_len);
  for (std::uint8_t& byte : payload) byte = random() % 2 == 0 ? std::uint8_t{1} : static_cast<std::uint8_t>(random());
  return frame_of(id, payload);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  std::mt19937 random(seed);
  if (size < 2 || random() % 8 == 0) return LLVMFuzzerMutate(data, size, most);
  std::vector<Bytes> stream = pieces(data + 1, size - 1);
  const std::size_t at = random() % stream.size();
  switch (random() % 8) {
    case 0:
      data[0] = static_cast<std::uint8_t>(random());  // the situation
      break;
    case 1: stream.insert(stream.begin() + static_cast<std::ptrdiff_t>(at), made_up(random)); break;
    case 2: stream.insert(stream.begin() + static_cast<std::ptrdiff_t>(at), Bytes(stream[at])); break;
    case 3: std::swap(stream[at], stream[random() % stream.size()]); break;
    case 4: stream.erase(stream.begin() + static_cast<std::ptrdiff_t>(at)); break;
    case 5:  // when it comes, and from where
      if (looks_like_a_frame(stream[at])) {
        stream[at][3 + random() % 2] = static_cast<std::uint8_t>(random());
        seal(stream[at]);
      }
      break;
    default:
      if (looks_like_a_frame(stream[at])) change_payload(stream[at], random);
  }
  std::size_t used = 1;
  for (const Bytes& piece : stream) {
    if (used + piece.size() > most) break;
    std::copy(piece.begin(), piece.end(), data + used);
    used += piece.size();
  }
  return used;
}
