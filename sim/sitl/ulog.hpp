// Writer of ULog files (PX4's flight log format, version 1). Why: pyulog, PlotJuggler and Flight Review read it.
//
//   Ulog log(path);                                 // info() and param() while nothing is recorded yet, info() ever
//   const auto topic = log.add_topic("rotor_commands", "float[4] thrust;");
//   log.begin(topic, t_us); log.put(1.5F); ... log.end();
#pragma once
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

namespace halfroll::sitl {

class Ulog {
 public:
  using Topic = std::uint16_t;

  /// Throws std::runtime_error if the file cannot be made.
  explicit Ulog(const std::string& path);
  ~Ulog() { flush(); }

  void info(const std::string& key, const std::string& text);
  void param(const std::string& id, float initial);
  /// `fields` in ULog notation without the time stamp, floats before bytes: "float[3] p;uint8_t mode;".
  Topic add_topic(const std::string& name, const std::string& fields);
  /// All topics are known; data follows.
  void begin_data();

  void begin(Topic topic, std::uint64_t t_us);
  void put(float x) { append(&x, sizeof x); }
  void put(std::uint8_t x) { append(&x, sizeof x); }
  void end();

  /// A line of text; severity as in syslog, 0 emergency to 7 debug.
  void text(std::uint8_t severity, std::uint64_t t_us, const std::string& line);

  void flush();
  bool good() const { return file_.good(); }

 private:
  void open_message(char type);
  void close_message();
  void append(const void* bytes, std::size_t size);
  void append(const std::string& text) { append(text.data(), text.size()); }

  std::ofstream file_;
  std::vector<char> buffer_;
  std::size_t message_ = 0;  // where the open message starts
  std::vector<std::string> topics_;
};

}  // namespace halfroll::sitl
