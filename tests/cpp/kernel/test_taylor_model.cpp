#include <doctest/doctest.h>

#include <random>

#include "kernel/taylor_model.hpp"

namespace halfroll::planner {
namespace {

Pack at(const TaylorModel& a, double t) {
  Pack sum{};
  for (int i = TaylorModel::kDegree; i >= 0; --i) sum = t * sum + a.c[i];
  return sum;
}

/// Another one in each lane.
TaylorModel random_model(std::mt19937& generator, double constant, double spread) {
  std::normal_distribution<double> normal(0.0, spread);
  TaylorModel a;
  for (Pack& c : a.c) {
    for (int lane = 0; lane < Pack::kWidth; ++lane) c.v[lane] = normal(generator);
  }
  a.c[0] = splat(constant);
  return a;
}

}  // namespace

TEST_CASE("every operation encloses the function it stands for") {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 200; ++trial) {
    const TaylorModel a = random_model(generator, 2.0, 0.08), b = random_model(generator, -0.4, 0.1);
    const TaylorModel product = a * b, sum = a + b, root = inverse_sqrt(a), one_over = inverse(a), sin = sine(b),
                      cos = cosine(b);
    for (double t = -1.0; t <= 1.0; t += 0.125) {
      for (int lane = 0; lane < Pack::kWidth; ++lane) {
        const auto off = [&](const TaylorModel& model, double truth) {
          return std::abs(at(model, t).v[lane] - truth) - model.remainder.v[lane];
        };
        const double x = at(a, t).v[lane], y = at(b, t).v[lane];
        CHECK(off(product, x * y) <= 0.0);
        CHECK(off(sum, x + y) <= 0.0);
        CHECK(off(root, 1.0 / std::sqrt(x)) <= 0.0);
        CHECK(off(one_over, 1.0 / x) <= 0.0);
        CHECK(off(sin, std::sin(y)) <= 0.0);
        CHECK(off(cos, std::cos(y)) <= 0.0);
        const Interval interval = range(product);
        CHECK(interval.low.v[lane] <= x * y);
        CHECK(interval.high.v[lane] >= x * y);
      }
    }
  }
}

TEST_CASE("remainders are as small as what a series of this degree leaves out") {
  TaylorModel a;
  a.c[0] = splat(1.0);
  a.c[1] = splat(0.1);  // the next terms are 1e-8, 2e-9 and 2e-13
  CHECK(inverse(a).remainder.v[0] < 1.5e-8);
  CHECK(inverse_sqrt(a).remainder.v[0] < 1e-8);
  CHECK(sine(a).remainder.v[0] < 4e-13);
}

TEST_CASE("what enters with a remainder leaves with one that holds all it may be") {
  std::mt19937 generator(3);
  TaylorModel a = random_model(generator, 2.0, 0.05);
  a.remainder = splat(0.1);
  const TaylorModel root = inverse_sqrt(a), one_over = inverse(a), sin = sine(a);
  for (double t = -1.0; t <= 1.0; t += 0.125) {
    for (double off : {-0.1, 0.1}) {
      const double x = at(a, t).v[0] + off;
      CHECK(std::abs(at(root, t).v[0] - 1.0 / std::sqrt(x)) <= root.remainder.v[0]);
      CHECK(std::abs(at(one_over, t).v[0] - 1.0 / x) <= one_over.remainder.v[0]);
      CHECK(std::abs(at(sin, t).v[0] - std::sin(x)) <= sin.remainder.v[0]);
    }
  }
}

TEST_CASE("an argument that may reach zero has no inverse and says so") {
  TaylorModel a;
  a.c[0] = splat(1.0);
  a.c[1].v = Pack::Lanes{1.0, 0.1, -1.1, 0.0};
  const Interval interval = range(inverse(a) * a);
  for (int lane = 0; lane < Pack::kWidth; ++lane) {
    const bool failed = lane % 2 == 0;
    CHECK(std::isfinite(inverse(a).remainder.v[lane]) != failed);
    CHECK(std::isfinite(inverse_sqrt(a).remainder.v[lane]) != failed);
    CHECK((interval.high.v[lane] == std::numeric_limits<double>::infinity()) == failed);
    CHECK((interval.low.v[lane] == -std::numeric_limits<double>::infinity()) == failed);
  }
}

}  // namespace halfroll::planner
