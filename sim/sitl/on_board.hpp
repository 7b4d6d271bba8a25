// The firmware at the end of a byte channel, in lockstep: a request, an answer. If wanted the same firmware flies in
// this process beside it, on the same inputs, and every bit that differs is counted.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "boards/host/byte_channel.hpp"
#include "sim/sitl/firmware.hpp"

namespace halfroll::sitl {

class OnBoard final : public Firmware {
 public:
  /// `beside`: flies the same inputs; may be null.
  OnBoard(std::unique_ptr<host::ByteChannel> channel, std::unique_ptr<InProcess> beside)
      : channel_(std::move(channel)), beside_(std::move(beside)) {}

  void start(const boards::Start& start) override;
  Outputs step(const Inputs& in) override;
  LinkOutputs service(const LinkInputs& in) override;
  void ask_time() override;
  const hil::Shown& shown() const override { return shown_; }
  const Params& params() const override { return params_; }
  link::StoredImage stored(link::StorageSlot) const override { return {}; }
  bool has_links_of_its_own() const override { return true; }
  /// One line of JSON.
  std::string finish() override;

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Sink {
    Bytes& bytes;
    void take(const std::uint8_t* from, std::size_t size) { bytes.insert(bytes.end(), from, from + size); }
  };

  template <class Body>
  bool exchange(hil::Kind kind, const Body& body);
  hil::Kind receive();
  void read_links(hil::Reader& reader);
  LinkOutputs links() const;
  void compare(const RotorCommands& board, const RotorCommands& here);
  void compare(const LinkOutputs& here, std::size_t first);

  std::unique_ptr<host::ByteChannel> channel_;
  std::unique_ptr<InProcess> beside_;
  Bytes request_, answer_;
  std::vector<link::TxFrame> tx_;
  hil::Shown shown_;
  Params params_;
  bool ask_time_ = false;

  std::uint64_t steps_ = 0, differing_bits_ = 0, differing_frames_ = 0;
  std::vector<std::uint32_t> instructions_;  // of each step
};

}  // namespace halfroll::sitl
