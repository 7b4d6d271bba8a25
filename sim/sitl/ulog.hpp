// Writer of ULog files (PX4's flight log format, version 1). Why: pyulog, PlotJuggler and Flight Review read it.
//
//   Ulog log(path);                                 // info() and param() while nothing is recorded yet, info() ever
//   const auto topic = log.add_topic("rotor_commands", "float[4] thrust;");
//   log.begin(topic, t_us); log.put(1.5F); ... log.end();
//
// Whole messages go to the file at each flush(), and whenever kLargest bytes wait; each flush appends them in one
// piece, so others may append to the same file, and what a killed process leaves can be read up to there.
#pragma once
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace halfroll::sitl {

class Ulog {
 public:
  using Topic = std::uint16_t;

  /// Throws std::runtime_error if the file cannot be made.
  explicit Ulog(const std::string& path);
  Ulog(const Ulog&) = delete;
  Ulog& operator=(const Ulog&) = delete;
  ~Ulog();

  void info(const std::string& key, const std::string& text);
  void info(const std::string& key, std::int32_t number);
  void info(const std::string& key, float number);
  void param(const std::string& id, float initial);
  void param(const std::string& id, std::int32_t initial);
  /// `fields` in ULog notation without the time stamp, the largest first: "float[3] p;uint8_t mode;".
  Topic add_topic(const std::string& name, const std::string& fields);
  /// A topic that somebody else will subscribe and fill: only its fields are told.
  void announce(const std::string& name, const std::string& fields);
  /// All topics are known; data follows.
  void begin_data();

  void begin(Topic topic, std::uint64_t t_us);
  template <class Number>
  void put(Number x) {
    static_assert(std::is_arithmetic_v<Number> && !std::is_same_v<Number, bool>, "a number as ULog has them");
    append(&x, sizeof x);
  }
  void put_bytes(const std::uint8_t* bytes, std::size_t size) { append(bytes, size); }
  void end();

  /// A line of text; severity as in syslog, 0 emergency to 7 debug.
  void text(std::uint8_t severity, std::uint64_t t_us, const std::string& line);

  void flush();
  bool good() const { return good_; }

 private:
  static constexpr std::size_t kLargest = 256 * 1024;

  void open_message(char type);
  void close_message();
  void typed(char type, const std::string& type_and_key, const void* value, std::size_t size);
  void append(const void* bytes, std::size_t size);
  void append(const std::string& text) { append(text.data(), text.size()); }

  int file_ = -1;
  bool good_ = true;
  std::vector<char> buffer_;
  std::size_t message_ = 0;  // where the open message starts
  std::vector<std::string> topics_;
};

}  // namespace halfroll::sitl
