// Attitude as a unit quaternion, Hamilton, [w, x, y, z]. Why: the only place that knows the product's signs; q_WB takes
// body vectors to world and in a product the inner letters cancel: q_DB = conj(q_WD) * q_WB.
#pragma once
#include <cmath>

#include "core/trig.hpp"
#include "core/types.hpp"

namespace halfroll {

inline Quat operator*(const Quat& p, const Quat& q) {
  return {p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z, p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
          p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x, p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w};
}

inline Quat operator-(const Quat& q) { return {-q.w, -q.x, -q.y, -q.z}; }

inline Quat conj(const Quat& q) { return {q.w, -q.x, -q.y, -q.z}; }

inline Vec3 vec(const Quat& q) { return {q.x, q.y, q.z}; }

inline float dot(const Quat& p, const Quat& q) { return p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z; }

inline bool is_finite(const Quat& q) {
  return std::isfinite(q.w) && std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z);
}

/// Unit quaternion along q; the identity where q has no direction.
inline Quat normalised(const Quat& q) {
  const float size = std::sqrt(dot(q, q));
  if (!(size > 1e-15F && std::isfinite(size))) return {};
  const float scale = 1.F / size;
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/// R(q): columns are the body axes in world.
inline Mat3 rotation_matrix(const Quat& q) {
  Mat3 r;
  r << 1.F - 2.F * (q.y * q.y + q.z * q.z), 2.F * (q.x * q.y - q.w * q.z), 2.F * (q.x * q.z + q.w * q.y),
      2.F * (q.x * q.y + q.w * q.z), 1.F - 2.F * (q.x * q.x + q.z * q.z), 2.F * (q.y * q.z - q.w * q.x),
      2.F * (q.x * q.z - q.w * q.y), 2.F * (q.y * q.z + q.w * q.x), 1.F - 2.F * (q.x * q.x + q.y * q.y);
  return r;
}

/// q v q*: from body to world with q_WB.
inline Vec3 rotate(const Quat& q, const Vec3& v) {
  const Vec3 t = 2.F * vec(q).cross(v);
  return v + q.w * t + vec(q).cross(t);
}

/// R(q) e3: where body up points in world, the thrust axis n.
inline Vec3 up_axis(const Quat& q) {
  return {2.F * (q.x * q.z + q.w * q.y), 2.F * (q.y * q.z - q.w * q.x), 1.F - 2.F * (q.x * q.x + q.y * q.y)};
}

/// The rotation by |v| about v.
inline Quat from_rotation_vector(const Vec3& v) {
  const float half2 = 0.25F * v.squaredNorm();
  if (half2 < 0.01F) {  // series: exact to a float here, no root, and never 0/0
    const float scale = 0.5F - half2 * (1.F / 12.F - half2 * (1.F / 240.F));
    return {1.F - half2 * (0.5F - half2 * (1.F / 24.F)), scale * v.x(), scale * v.y(), scale * v.z()};
  }
  const float half = std::sqrt(half2), scale = 0.5F * sine(half) / half;
  return {cosine(half), scale * v.x(), scale * v.y(), scale * v.z()};
}

/// The rotation vector of q, the short way round (at most pi).
inline Vec3 rotation_vector(const Quat& q) {
  const Vec3 v = q.w < 0.F ? Vec3(-vec(q)) : vec(q);
  const float size = v.norm();
  if (size < 1e-6F) return 2.F * v;
  return v * (2.F * arctangent2(size, std::abs(q.w)) / size);
}

inline Quat about_z(float angle) { return {cosine(0.5F * angle), 0.F, 0.F, sine(0.5F * angle)}; }

/// Yaw left when the body is brought upright by the least rotation: psi of q = chart A(n) * about_z(psi). 0 upside
/// down.
inline float heading_after_levelling(const Quat& q) { return wrapped_angle(2.F * arctangent2(q.z, q.w)); }

}  // namespace halfroll
