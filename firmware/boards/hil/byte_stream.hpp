// Numbers to bytes and back, little-endian, without padding. Why: host and board lay structs out differently, and one
// list of fields for both directions cannot disagree with itself.
#pragma once
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <tuple>
#include <type_traits>

#include "core/types.hpp"

namespace halfroll::hil {

/// A struct is written as the fields that `fields(x, tag)` ties, found by argument; x may be const.
template <class T>
struct Tag {};

template <class X>
auto fields_of(X& x) {
  return fields(x, Tag<std::remove_const_t<X>>{});
}

/// Writes into anything with take(bytes, size).
template <class Sink>
class Writer {
 public:
  explicit Writer(Sink& sink) : sink_(sink) {}

  template <class... T>
  void operator()(const T&... all) {
    (put(all), ...);
  }
  void bytes(const std::uint8_t* from, std::size_t size) { sink_.take(from, size); }

 private:
  template <class T>
  void put(const T& x) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      std::array<std::uint8_t, sizeof(T)> raw;
      std::memcpy(raw.data(), &x, sizeof x);
      sink_.take(raw.data(), raw.size());
    } else {
      parts(x);
    }
  }
  template <class T>
  void parts(const T& x) {
    std::apply(*this, fields_of(x));
  }
  template <class T, std::size_t N>
  void parts(const std::array<T, N>& all) {
    for (const T& each : all) put(each);
  }
  template <class T>
  void parts(const std::optional<T>& perhaps) {
    put(perhaps.has_value());
    if (perhaps) put(*perhaps);
  }
  void parts(const Vec3& v) { (*this)(v.x(), v.y(), v.z()); }

  Sink& sink_;
};

/// Reads what a Writer wrote; a message that is too short reads as zeros and is not good().
class Reader {
 public:
  Reader(const std::uint8_t* from, std::size_t size) : at_(from), left_(size) {}

  template <class... T>
  void operator()(T&... all) {
    (get(all), ...);
  }
  /// Where the next `size` bytes lie.
  const std::uint8_t* bytes(std::size_t size) {
    good_ = good_ && size <= left_;
    if (!good_) return nullptr;
    const std::uint8_t* here = at_;
    at_ += size;
    left_ -= size;
    return here;
  }
  bool good() const { return good_; }

 private:
  template <class T>
  void get(T& x) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      const std::uint8_t* raw = bytes(sizeof x);
      if (raw != nullptr) {
        std::memcpy(&x, raw, sizeof x);
      } else {
        x = T{};
      }
    } else {
      parts(x);
    }
  }
  template <class T>
  void parts(T& x) {
    std::apply(*this, fields_of(x));
  }
  template <class T, std::size_t N>
  void parts(std::array<T, N>& all) {
    for (T& each : all) get(each);
  }
  template <class T>
  void parts(std::optional<T>& perhaps) {
    bool there = false;
    get(there);
    perhaps.reset();
    if (there) get(perhaps.emplace());
  }
  void parts(Vec3& v) { (*this)(v.x(), v.y(), v.z()); }

  const std::uint8_t* at_;
  std::size_t left_;
  bool good_ = true;
};

}  // namespace halfroll::hil
