// Geodesy in integers against the contract's formula in doubles, over the whole earth.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "link/frames.hpp"

using namespace halfroll;
using namespace halfroll::link;

namespace {

struct Radii {
  double north, east;  // metres per radian
};
Radii radii(double lat_deg, double alt_m) {
  const double rad = std::acos(-1.0) / 180.0, s = std::sin(lat_deg * rad), a = 6378137.0, e2 = 6.69437999014e-3;
  const double root = std::sqrt(1.0 - e2 * s * s);
  return {a * (1.0 - e2) / (root * root * root) + alt_m, std::cos(lat_deg * rad) * (a / root + alt_m)};
}

}  // namespace

TEST_CASE("a metre is a metre to a billionth, wherever the origin lies") {
  std::mt19937 random(3);
  std::uniform_int_distribution<std::int32_t> latitude(-899000000, 899000000), altitude(-500000, 9000000);
  for (int n = 0; n < 2000; ++n) {
    const std::int32_t lat = latitude(random), alt = altitude(random);
    const Radii exact = radii(lat * 1e-7, alt * 1e-3);
    const Scales scales = scales_at(lat, alt);
    const double per_unit = std::acos(-1.0) / 180e7, one = 1099511627776.0;
    CHECK(static_cast<double>(scales.north) / one == doctest::Approx(exact.north * per_unit).epsilon(1e-10));
    CHECK(std::fabs(static_cast<double>(scales.east) / one - exact.east * per_unit) < 1e-11);
  }
}

TEST_CASE("a place 50 km away comes out to the last bit or so of a float") {
  std::mt19937 random(4);
  std::uniform_int_distribution<std::int32_t> latitude(-800000000, 800000000), offset(-4000000, 4000000);
  for (int n = 0; n < 2000; ++n) {
    const Origin origin(latitude(random), 1234567890, 488000);
    const GlobalPosition place{origin.lat_degE7() + offset(random), origin.lon_degE7() + offset(random), 500000};
    const Radii exact = radii(origin.lat_degE7() * 1e-7, 488.0);
    const double per_unit = std::acos(-1.0) / 180e7;
    const double north = (place.lat_degE7 - origin.lat_degE7()) * per_unit * exact.north;
    const double west = -(place.lon_degE7 - origin.lon_degE7()) * per_unit * exact.east;
    const Vec3 p = local_from_global(origin, place);
    CHECK(std::fabs(static_cast<double>(p.x()) - north) < 1e-7 * std::fabs(north) + 1e-6);
    CHECK(std::fabs(static_cast<double>(p.y()) - west) < 1e-7 * std::fabs(west) + 1e-6);
    const GlobalPosition back = global_from_local(origin, p);
    CHECK(std::abs(back.lat_degE7 - place.lat_degE7) <= 1);  // a float has 2 mm there, a unit 11 mm
    CHECK(std::abs(back.lon_degE7 - place.lon_degE7) <= 1 + static_cast<int>(2.0 / exact.east * 1e6));
  }
}

TEST_CASE("degrees in a float become the nearest integer, halves the even one") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> angle(-214.F, 214.F);
  for (int n = 0; n < 5000; ++n) {
    const float x = n % 2 == 0 ? angle(random) : angle(random) * 1e-6F;
    CHECK(to_degE7(x) == static_cast<std::int32_t>(std::nearbyint(static_cast<double>(x) * 1e7)));
    CHECK(scaled_or_not_given(x * 1e6F, 1) == static_cast<std::int32_t>(std::nearbyint(static_cast<double>(x * 1e6F))));
  }
  CHECK(scaled_or_not_given(2.5F, 1) == 2);
  CHECK(scaled_or_not_given(3.5F, 1) == 4);
  CHECK(scaled_or_not_given(-2.5F, 1) == -2);
  CHECK(scaled_or_not_given(2147483520.F, 1) == 2147483520);
  CHECK(scaled_or_not_given(-3e9F, 1) == INT32_MAX);
}
