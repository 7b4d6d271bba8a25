// Where north-west-up / forward-left-up meets the wire's NED, FRD and degE7, and nowhere else in C++.
// Why: both frame pairs differ by a half turn about x, so every function here undoes itself, and one test can hold it.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>

#include "core/quaternion.hpp"
#include "core/trig.hpp"
#include "link/fixed_point.hpp"

namespace halfroll::link {

inline constexpr float kDegree = kPi / 180.F;

/// A vector of W or B with the wire's axes, or the other way round.
inline Vec3 to_wire(const Vec3& v) { return {v.x(), -v.y(), -v.z()}; }
inline Vec3 from_wire(const Vec3& v) { return to_wire(v); }

/// body -> world with both frames turned.
inline Quat to_wire(const Quat& q) { return {q.w, q.x, -q.y, -q.z}; }
inline Quat from_wire(const Quat& q) { return to_wire(q); }

/// Heading or turn: clockwise degrees on the wire, counter-clockwise radians inside.
inline float yaw_from_wire_deg(float heading_deg) { return -kDegree * heading_deg; }

/// A wire integer never wraps: clamped, 0 for what is no number.
template <class Integer>
Integer rounded(float x) {
  constexpr auto kLeast = std::numeric_limits<Integer>::min(), kMost = std::numeric_limits<Integer>::max();
  if (!(x == x)) return 0;
  if (x <= static_cast<float>(kLeast)) return kLeast;
  return x >= static_cast<float>(kMost) ? kMost : static_cast<Integer>(std::nearbyint(x));
}

/// Metres of one 1e-7 degree, in units of 2^-40.
struct Scales {
  std::int64_t north, east;
};
constexpr Scales scales_at(std::int32_t lat_degE7, std::int32_t alt_mm) {
  constexpr fixed::Q60 kRadius = 876604474381041664;   // 6378137 m, in 2^23 m
  constexpr fixed::Q60 kFlattened = 7718094650642178;  // e², WGS84
  constexpr fixed::Q60 kPerUnit = 16879788771717060;   // 2^23 pi / 180e7
  const fixed::Turn latitude = fixed::turn(fixed::ratio(lat_degE7, 900000000));
  const fixed::Q60 y =
      fixed::inverse_root(fixed::kOne - fixed::times(kFlattened, fixed::times(latitude.sine, latitude.sine)));
  const fixed::Q60 normal = fixed::times(kRadius, y);
  const fixed::Q60 meridian = fixed::times(fixed::times(normal, fixed::times(y, y)), fixed::kOne - kFlattened);
  const fixed::Q60 height = alt_mm * (std::int64_t{1} << 30U) / 1000 * 128;
  const fixed::Q60 north = fixed::times(meridian + height, kPerUnit);
  const fixed::Q60 east = fixed::times(fixed::times(normal + height, kPerUnit), latitude.cosine);
  return {north >> 20, east >> 20};
}

/// Local origin: where W has its zero. WGS84, altitude above mean sea level (= ellipsoid height in simulation).
class Origin {
 public:
  Origin() = default;
  Origin(std::int32_t lat_degE7, std::int32_t lon_degE7, std::int32_t alt_mm)
      : lat_degE7_(lat_degE7), lon_degE7_(lon_degE7), alt_mm_(alt_mm), scales_(scales_at(lat_degE7, alt_mm)) {}

  std::int32_t lat_degE7() const { return lat_degE7_; }
  std::int32_t lon_degE7() const { return lon_degE7_; }
  std::int32_t alt_mm() const { return alt_mm_; }
  float alt_m() const { return static_cast<float>(alt_mm_) / 1000.F; }
  const Scales& scales() const { return scales_; }

  auto state() const { return std::tie(lat_degE7_, lon_degE7_, alt_mm_); }
  bool operator==(const Origin& o) const { return state() == o.state(); }

 private:
  static constexpr Scales kNullIsland = scales_at(0, 0);
  std::int32_t lat_degE7_ = 0, lon_degE7_ = 0, alt_mm_ = 0;
  Scales scales_ = kNullIsland;
};

struct GlobalPosition {
  std::int32_t lat_degE7 = 0;
  std::int32_t lon_degE7 = 0;
  std::int32_t alt_mm = 0;  // above mean sea level
};

/// x = mantissa 2^exponent, exactly. Why: the cast from float to 64 bits is made with doubles where there is no such
/// instruction.
struct Binary {
  std::int64_t mantissa;
  int exponent;
};
inline Binary binary_of(float x) {
  int exponent = 0;
  const float share = std::frexp(x, &exponent);
  return {static_cast<std::int32_t>(share * 16777216.F), exponent - 24};
}

/// x * factor to the nearest integer, ties to even and without a rounding before; what does not fit, or is no number,
/// becomes INT32_MAX, the wire's "not given". `factor` below 2^38.
inline std::int32_t scaled_or_not_given(float x, std::int64_t factor) {
  constexpr std::int32_t kNotGiven = std::numeric_limits<std::int32_t>::max();
  if (!(std::fabs(x) < 2147483648.F)) return kNotGiven;
  const Binary binary = binary_of(x);
  const std::int64_t product = binary.mantissa * factor;
  const int shift = -binary.exponent;
  if (shift > 62) return 0;
  if (shift <= 0) {
    return product == 0 || (shift > -8 && std::abs(product) < (std::int64_t{1} << (31 + shift)))
               ? static_cast<std::int32_t>(product * (std::int64_t{1} << -shift))
               : kNotGiven;
  }
  const std::int64_t half = std::int64_t{1} << (shift - 1), down = product >> shift, rest = product - down * 2 * half;
  const std::int64_t nearest = down + (rest > half || (rest == half && (down & 1) != 0) ? 1 : 0);
  return std::abs(nearest) < kNotGiven ? static_cast<std::int32_t>(nearest) : kNotGiven;
}

/// Degrees to the wire's integers.
inline std::int32_t to_degE7(float angle_deg) { return scaled_or_not_given(angle_deg, 10000000); }
inline float from_degE7(std::int32_t angle_degE7) { return static_cast<float>(angle_degE7) / 1e7F; }

inline float metres(std::int64_t units, std::int64_t scale) {
  constexpr std::int64_t kLow = 1023;
  const std::int64_t q30 = units * (scale >> 10) + ((units * (scale & kLow)) >> 10);
  return static_cast<float>(q30) * (1.F / 1073741824.F);
}

inline std::int32_t units_of(float metres, std::int64_t scale) {
  constexpr float kFarthest = 4194304.F;  // beyond, a place has no meaning in a plane
  const float bounded = metres < -kFarthest ? -kFarthest : metres < kFarthest ? metres : kFarthest;
  const Binary binary = binary_of(bounded);
  const int shift = binary.exponent + 40;
  const std::int64_t q40 = shift < -40 ? 0
                           : shift < 0 ? binary.mantissa >> -shift
                                       : binary.mantissa * (std::int64_t{1} << shift);
  const std::int64_t half = q40 < 0 ? -(scale / 2) : scale / 2;
  return scale < 1 ? 0 : static_cast<std::int32_t>((q40 + half) / scale);
}

/// Position in W [m] of a place on earth; the contract's local formula, the inverse of global_from_local.
inline Vec3 local_from_global(const Origin& origin, const GlobalPosition& place) {
  const Scales& scales = origin.scales();
  const std::int64_t up_mm = std::int64_t{place.alt_mm} - origin.alt_mm();
  return {metres(std::int64_t{place.lat_degE7} - origin.lat_degE7(), scales.north),
          -metres(std::int64_t{place.lon_degE7} - origin.lon_degE7(), scales.east), static_cast<float>(up_mm) / 1000.F};
}

inline GlobalPosition global_from_local(const Origin& origin, const Vec3& p_W) {
  const Scales& scales = origin.scales();
  return {origin.lat_degE7() + units_of(p_W.x(), scales.north), origin.lon_degE7() + units_of(-p_W.y(), scales.east),
          origin.alt_mm() + rounded<std::int32_t>(p_W.z() * 1000.F)};
}

/// The attitude that has these roll, pitch and heading on the wire (intrinsic yaw-pitch-roll) [rad].
inline Quat quat_from_wire_angles(float roll, float pitch, float yaw) {
  const Quat about_x{cosine(0.5F * roll), sine(0.5F * roll), 0.F, 0.F};
  const Quat about_y{cosine(0.5F * pitch), 0.F, sine(0.5F * pitch), 0.F};
  return from_wire(about_z(yaw) * about_y * about_x);
}

/// Roll, pitch and heading [rad] of the wire's ATTITUDE: roll and yaw in (-pi, pi], pitch in [-pi/2, pi/2].
inline Vec3 wire_angles(const Quat& q_WB) {
  const Quat q = to_wire(q_WB);
  const float nose_x = 1.F - 2.F * (q.y * q.y + q.z * q.z), nose_y = 2.F * (q.w * q.z + q.x * q.y);
  return {arctangent2(2.F * (q.w * q.x + q.y * q.z), 1.F - 2.F * (q.x * q.x + q.y * q.y)),
          arctangent2(2.F * (q.w * q.y - q.z * q.x), std::sqrt(nose_x * nose_x + nose_y * nose_y)),
          arctangent2(nose_y, nose_x)};
}

}  // namespace halfroll::link
