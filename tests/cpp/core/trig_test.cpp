// Polynomial trigonometry against libm. Why: its documented error bound is what the rest of the core relies on.
#include "core/trig.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

namespace halfroll {

TEST_CASE("sine and cosine stay within 2e-6 of libm up to 1000 rad") {
  double worst = 0.0;
  for (int i = -2000000; i <= 2000000; ++i) {
    const float x = static_cast<float>(i) * 5e-4F;
    worst = std::max(worst, std::abs(static_cast<double>(sine(x)) - std::sin(static_cast<double>(x))));
    worst = std::max(worst, std::abs(static_cast<double>(cosine(x)) - std::cos(static_cast<double>(x))));
  }
  MESSAGE("largest error " << worst);
  CHECK(worst < 2e-6);
}

TEST_CASE("the sine of a small angle keeps its relative precision") {
  for (float x = 1e-20F; x < 0.1F; x *= 3.F)
    CHECK(sine(x) == doctest::Approx(std::sin(static_cast<double>(x))).epsilon(1e-6));
}

TEST_CASE("the arctangent stays within 2e-6 of libm in every direction and at every size") {
  double worst = 0.0;
  for (const float size : {1e-30F, 1.F, 1e30F}) {
    for (int i = -31415; i <= 31415; ++i) {
      const float x = size * static_cast<float>(std::cos(i * 1e-4)), y = size * static_cast<float>(std::sin(i * 1e-4));
      worst = std::max(worst, std::abs(static_cast<double>(arctangent2(y, x)) -
                                       std::atan2(static_cast<double>(y), static_cast<double>(x))));
    }
  }
  MESSAGE("largest error " << worst);
  CHECK(worst < 2e-6);
}

TEST_CASE("the arctangent knows the axes and the origin") {
  CHECK(arctangent2(0.F, 0.F) == 0.F);
  CHECK(arctangent2(0.F, 1.F) == 0.F);
  CHECK(arctangent2(1.F, 0.F) == doctest::Approx(kPi / 2.F));
  CHECK(arctangent2(-1.F, 0.F) == doctest::Approx(-kPi / 2.F));
  CHECK(arctangent2(0.F, -1.F) == doctest::Approx(kPi));
}

TEST_CASE("trigonometry of what is not finite is finite") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float x : {nan, inf, -inf, 1e30F}) {
    CHECK(std::abs(sine(x)) <= 1.F);
    CHECK(std::abs(cosine(x)) <= 1.F);
    CHECK(std::abs(wrapped_angle(x)) <= kPi);
    for (const float y : {nan, inf, 1.F}) CHECK(std::abs(arctangent2(x, y)) <= kPi);
    for (const float y : {nan, inf, 1.F}) CHECK(std::abs(arctangent2(y, x)) <= kPi);
  }
}

TEST_CASE("a wrapped angle points where the angle does, within half a turn") {
  for (float x = -50.F; x < 50.F; x += 0.37F) {
    CHECK(std::abs(wrapped_angle(x)) <= kPi + 1e-5F);
    CHECK(std::cos(wrapped_angle(x) - x) == doctest::Approx(1.F));
  }
}

}  // namespace halfroll
