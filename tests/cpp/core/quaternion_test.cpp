// Our quaternions against Eigen's. Why: every sign of the paper's attitude law rests on this product.
#include "core/quaternion.hpp"

#include <doctest/doctest.h>

#include "oracle.hpp"

namespace halfroll {
using oracle::Quatd;
using oracle::Random;
using oracle::Vec3d;

TEST_CASE("product, rotation and matrix are Eigen's") {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Quatd p = random.attitude(), q = random.attitude();
    const Vec3d v = random.normal3(3.0);
    CHECK(oracle::angle_between(oracle::to_core(p) * oracle::to_core(q), oracle::to_core(p * q)) < 1e-6);
    CHECK((rotate(oracle::to_core(q), v.cast<float>()).cast<double>() - q * v).norm() < 1e-5);
    CHECK((rotation_matrix(oracle::to_core(q)).cast<double>() - q.toRotationMatrix()).norm() < 1e-6);
    CHECK((up_axis(oracle::to_core(q)).cast<double>() - q * Vec3d::UnitZ()).norm() < 1e-6);
    CHECK((rotate(conj(oracle::to_core(q)), v.cast<float>()).cast<double>() - q.conjugate() * v).norm() < 1e-5);
  }
}

TEST_CASE("i j = k: the product is Hamilton's") {
  CHECK(Quat{0.F, 1.F, 0.F, 0.F} * Quat{0.F, 0.F, 1.F, 0.F} == Quat{0.F, 0.F, 0.F, 1.F});
}

TEST_CASE("a rotation vector turns by its length about itself, and comes back") {
  Random random(2);
  for (const double size : {0.0, 1e-30, 1e-7, 1e-3, 2.1e-3, 0.1, 1.0, 3.0}) {
    const Vec3d v = size * random.normal3(1.0).normalized();
    const Quat q = from_rotation_vector(v.cast<float>());
    CHECK(oracle::angle_between(oracle::from_core(q), oracle::turn(v)) < 1e-6);
    CHECK(dot(q, q) == doctest::Approx(1.0).epsilon(1e-6));
    CHECK((rotation_vector(q).cast<double>() - v).norm() <= 2e-6 * size);
    CHECK((rotation_vector(-q).cast<double>() - v).norm() <= 2e-6 * size);
  }
}

TEST_CASE("the unit quaternion of nothing, or of what is not finite, is the identity") {
  CHECK(normalised({0.F, 0.F, 0.F, 0.F}) == Quat{});
  CHECK(normalised({NAN, 0.F, 0.F, 0.F}) == Quat{});
  CHECK(normalised({INFINITY, 0.F, 0.F, 1.F}) == Quat{});
  CHECK(normalised({0.F, 0.F, -2.F, 0.F}) == Quat{0.F, 0.F, -1.F, 0.F});
}

TEST_CASE("the heading after levelling is what the least rotation to upright leaves") {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Quatd q = random.attitude();
    const Quatd levelled = Quatd::FromTwoVectors(q * Vec3d::UnitZ(), Vec3d::UnitZ()) * q;
    const Quat heading = about_z(heading_after_levelling(oracle::to_core(q)));
    if ((q * Vec3d::UnitZ()).z() > -0.99) CHECK(oracle::angle_between(oracle::from_core(heading), levelled) < 1e-4);
  }
}

}  // namespace halfroll
