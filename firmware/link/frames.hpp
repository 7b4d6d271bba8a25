// Where north-west-up / forward-left-up meets the wire's NED, FRD and degE7, and nowhere else in C++.
// Why: both frame pairs differ by a half turn about x, so every function here undoes itself, and one test can hold it.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/quaternion.hpp"

namespace halfroll::link {

inline constexpr double kDegree = 3.14159265358979323846 / 180.0;

/// A vector of W or B with the wire's axes, or the other way round.
inline Vec3 to_wire(const Vec3& v) { return {v.x(), -v.y(), -v.z()}; }
inline Vec3 from_wire(const Vec3& v) { return to_wire(v); }

/// body -> world with both frames turned.
inline Quat to_wire(const Quat& q) { return {q.w, q.x, -q.y, -q.z}; }
inline Quat from_wire(const Quat& q) { return to_wire(q); }

/// Heading or turn: clockwise degrees on the wire, counter-clockwise radians inside.
inline float yaw_from_wire_deg(float heading_deg) {
  return static_cast<float>(-kDegree * static_cast<double>(heading_deg));
}

/// Local origin: where W has its zero. WGS84, altitude above mean sea level (= ellipsoid height in simulation).
struct Origin {
  std::int32_t lat_degE7 = 0;
  std::int32_t lon_degE7 = 0;
  double alt_m = 0.0;
  bool operator==(const Origin& o) const {
    return lat_degE7 == o.lat_degE7 && lon_degE7 == o.lon_degE7 && alt_m == o.alt_m;
  }
};

struct GlobalPosition {
  std::int32_t lat_degE7 = 0;
  std::int32_t lon_degE7 = 0;
  double alt_m = 0.0;  // above mean sea level
};

/// Degrees to the wire's integers; what is no angle at all becomes INT32_MAX, the wire's "not given".
inline std::int32_t to_degE7(double angle_deg) {
  const double scaled = std::nearbyint(angle_deg * 1e7);
  if (!(scaled > -2147483648.0 && scaled < 2147483647.0)) return std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(scaled);
}
inline double from_degE7(std::int32_t angle_degE7) { return angle_degE7 * 1e-7; }

inline Origin origin_at(double lat_deg, double lon_deg, double alt_m) {
  return {to_degE7(lat_deg), to_degE7(lon_deg), alt_m};
}

/// Metres per radian of latitude and of longitude at the origin.
struct EarthRadii {
  double north, east;
};
inline EarthRadii earth_radii(const Origin& origin) {
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double latitude = from_degE7(origin.lat_degE7) * kDegree;
  const double s = std::sin(latitude), w2 = 1.0 - e2 * s * s;
  const double meridian = a * (1.0 - e2) / (w2 * std::sqrt(w2)), normal = a / std::sqrt(w2);
  return {meridian + origin.alt_m, std::cos(latitude) * (normal + origin.alt_m)};
}

/// Position in W [m] of a place on earth; the contract's local formula, the inverse of global_from_local.
inline Vec3 local_from_global(const Origin& origin, std::int32_t lat_degE7, std::int32_t lon_degE7, double alt_amsl_m) {
  const EarthRadii radii = earth_radii(origin);
  const double north = (std::int64_t{lat_degE7} - origin.lat_degE7) * 1e-7 * kDegree * radii.north;
  const double east = (std::int64_t{lon_degE7} - origin.lon_degE7) * 1e-7 * kDegree * radii.east;
  return {static_cast<float>(north), static_cast<float>(-east), static_cast<float>(alt_amsl_m - origin.alt_m)};
}

inline GlobalPosition global_from_local(const Origin& origin, const Vec3& p_W) {
  const EarthRadii radii = earth_radii(origin);
  const double dlat = static_cast<double>(p_W.x()) / radii.north / kDegree;
  const double dlon = static_cast<double>(-p_W.y()) / radii.east / kDegree;
  return {to_degE7(from_degE7(origin.lat_degE7) + dlat), to_degE7(from_degE7(origin.lon_degE7) + dlon),
          origin.alt_m + static_cast<double>(p_W.z())};
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
  const double w = static_cast<double>(q.w), x = static_cast<double>(q.x), y = static_cast<double>(q.y),
               z = static_cast<double>(q.z);
  const double s = 2.0 * (w * y - z * x);
  const double roll = std::atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y));
  const double pitch = std::asin(s > 1.0 ? 1.0 : (s < -1.0 ? -1.0 : s));
  const double yaw = std::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z));
  return {static_cast<float>(roll), static_cast<float>(pitch), static_cast<float>(yaw)};
}

}  // namespace halfroll::link
