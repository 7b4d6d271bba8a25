// All that the firmware heard, call by call, written into a flight's log and read back from it. Why: the world follows
// from its seed and the firmware from what it hears, so whatever came when, from whomever, flies again from this.
//
// Steps that heard nothing new are not written: between two calls they follow from the time.
#pragma once
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "autopilot.hpp"
#include "sim/sitl/ulog.hpp"

namespace halfroll::sitl {

enum class Call : std::uint8_t { kStart, kStep, kService, kAskTime };

class HeardLog {
 public:
  explicit HeardLog(Ulog& ulog);

  /// Before start(): an image that the firmware finds.
  void image(std::uint64_t t_us, link::StorageSlot slot, const link::StoredImage& image);
  void start(std::uint64_t t_us, std::uint64_t unix_us_at_wall_0);
  void call(std::uint64_t t_us, Call call, const LinkInputs& in);
  void ask_time(std::uint64_t t_us);

 private:
  void pieces(Ulog::Topic topic, std::uint64_t t_us, std::uint8_t first, std::uint8_t second, const std::uint8_t* bytes,
              std::size_t size);
  void end(std::uint64_t t_us, Call call, std::uint64_t wall_us);

  Ulog& ulog_;
  Ulog::Topic calls_, datagrams_, images_;
  std::uint64_t wall_us_ = 0;
};

/// One call, as it was made at t_us of vehicle time.
struct Heard {
  struct Image {
    link::StorageSlot slot;
    link::StoredState state;
    std::vector<std::uint8_t> bytes;
  };
  struct Piece {
    link::Endpoint from;
    std::vector<std::uint8_t> bytes;
  };
  Call call = Call::kStep;
  std::uint64_t t_us = 0;
  std::uint64_t wall_us = 0;  // of kStart: the time of day at wall 0
  std::vector<Piece> datagrams;
  std::vector<Image> images;  // of kStart
};

class HeardReader {
 public:
  /// Reads the log's head. Throws BadOption if it is no log, or holds nothing to replay.
  explicit HeardReader(const std::string& path);

  const std::string& info(const std::string& key) const;
  /// The next call; nothing at the end of what can be read.
  std::optional<Heard> next();
  /// Vehicle time of the last step that was logged, after next() has come to its end; before the first, nothing.
  std::optional<std::uint64_t> last_step_us() const { return last_step_us_; }

 private:
  struct Message {
    char type = 0;
    std::string body;
  };
  std::optional<Message> read();
  void subscribe(const std::string& body);

  std::string path_;
  std::ifstream file_;
  std::map<std::string, std::string> info_;
  std::optional<Message> first_;  // read ahead
  int calls_ = -1, datagrams_ = -1, images_ = -1, commands_ = -1;
  std::optional<std::uint64_t> last_step_us_;
};

}  // namespace halfroll::sitl
