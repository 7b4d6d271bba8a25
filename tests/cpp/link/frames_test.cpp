// Physical facts, which a round trip cannot prove, and the geodesy against the contract's formula written out again.
#include "link/frames.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace halfroll;
using namespace halfroll::link;

namespace {
const Origin kZurich{473977420, 85455940, 488000};
const float kHalf = std::sqrt(0.5F);
}  // namespace

TEST_CASE("a point west of home has negative east on the wire") { CHECK(to_wire(Vec3{0, 1, 0}).y() < 0); }
TEST_CASE("a point above home has negative down on the wire") { CHECK(to_wire(Vec3{0, 0, 1}).z() < 0); }
TEST_CASE("north stays north") { CHECK(to_wire(Vec3{1, 0, 0}).x() == 1.F); }

TEST_CASE("a nose that points west is heading 270 on the wire") {
  const Vec3 angles = wire_angles(Quat{kHalf, 0, 0, kHalf});  // a quarter turn counter-clockwise from north
  CHECK(angles.z() == doctest::Approx(-M_PI / 2));
  CHECK(angles.x() == doctest::Approx(0));
}
TEST_CASE("a raised nose is positive pitch on the wire") {
  const Quat nose_up{std::cos(0.1F), 0, -std::sin(0.1F), 0};  // about left, the other way
  CHECK(wire_angles(nose_up).y() == doctest::Approx(0.2));
}
TEST_CASE("the right wing down is positive roll on the wire") {
  CHECK(wire_angles(Quat{std::cos(0.1F), std::sin(0.1F), 0, 0}).x() == doctest::Approx(0.2));
}
TEST_CASE("upside down shows roll pi and no pitch") {
  const Vec3 angles = wire_angles(Quat{0, 1, 0, 0});
  CHECK(std::fabs(angles.x()) == doctest::Approx(M_PI));
  CHECK(angles.y() == doctest::Approx(0));
}
TEST_CASE("roll, pitch and heading make the attitude that shows them") {
  for (const Vec3& angles :
       {Vec3{0.2F, 0.F, 0.F}, Vec3{0.F, 0.3F, 0.F}, Vec3{0.F, 0.F, 1.5F}, Vec3{-3.F, -1.2F, -2.F}}) {
    const Quat q = quat_from_wire_angles(angles.x(), angles.y(), angles.z());
    CHECK((wire_angles(q) - angles).norm() < 1e-5F);
  }
  CHECK(quat_from_wire_angles(0.F, 0.F, 1.57079633F).z < 0.F);  // a nose that points east is clockwise, seen from above
}
TEST_CASE("turning frames twice changes no bit") {
  const Vec3 v{0.1F, -2.3F, 4.5F};
  const Quat q{0.5F, -0.5F, 0.1F, 0.7F};
  CHECK(from_wire(to_wire(v)) == v);
  CHECK(from_wire(to_wire(q)) == q);
}
TEST_CASE("a vector turned by a quaternion is the same vector on both sides of the frame change") {
  const Eigen::Quaternionf q = Eigen::Quaternionf(0.6F, 0.2F, -0.5F, 0.3F).normalized();
  const Vec3 v{1, 2, 3};
  const Quat wire = to_wire(Quat{q.w(), q.x(), q.y(), q.z()});
  const Vec3 there = Eigen::Quaternionf(wire.w, wire.x, wire.y, wire.z) * to_wire(v);
  CHECK((to_wire(Vec3(q * v)) - there).norm() < 1e-6F);
}

TEST_CASE("geodesy is the contract's formula to a tenth of a millimetre") {
  const std::int32_t lat = 474067420, lon = 85335940;  // about 1 km north and 0.9 km west
  const double rad = std::acos(-1.0) / 180.0, lat0 = 47.397742 * rad, s = std::sin(lat0);
  const double e2 = 6.69437999014e-3, a = 6378137.0, root = std::sqrt(1 - e2 * s * s);
  const double north = (47.4067420 - 47.397742) * rad * (a * (1 - e2) / (root * root * root) + 488.0);
  const double east = (8.5335940 - 8.545594) * rad * std::cos(lat0) * (a / root + 488.0);
  const Vec3 p = local_from_global(kZurich, {lat, lon, 500000});
  CHECK(static_cast<double>(p.x()) == doctest::Approx(north).epsilon(1e-7));
  CHECK(static_cast<double>(-p.y()) == doctest::Approx(east).epsilon(1e-7));
  CHECK(p.z() == 12.F);
  CHECK(p.y() > 0.F);  // west
}
TEST_CASE("geodesy and its inverse return the same integers") {
  for (const std::int32_t step : {-90001, -17, 0, 1, 12345, 400000}) {
    const Vec3 p = local_from_global(kZurich, {kZurich.lat_degE7() + step, kZurich.lon_degE7() - 2 * step, 480000});
    const GlobalPosition back = global_from_local(kZurich, p);
    CHECK(back.lat_degE7 == kZurich.lat_degE7() + step);
    CHECK(back.lon_degE7 == kZurich.lon_degE7() - 2 * step);
    CHECK(back.alt_mm == 480000);
  }
}
TEST_CASE("what is no angle is not given") {
  CHECK(to_degE7(NAN) == INT32_MAX);
  CHECK(to_degE7(1e9F) == INT32_MAX);
  CHECK(to_degE7(-8.5F) == -85000000);
}
