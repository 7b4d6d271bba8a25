#include <doctest/doctest.h>

#include <random>

#include "kernel/taylor_model.hpp"

namespace halfroll::planner {
namespace {

double at(const TaylorModel& a, double t) {
  double sum = 0.0;
  for (int i = TaylorModel::kDegree; i >= 0; --i) sum = sum * t + a.c[i];
  return sum;
}

TaylorModel random_model(std::mt19937& generator, double constant, double spread) {
  std::normal_distribution<double> normal(0.0, spread);
  TaylorModel a;
  for (double& c : a.c) c = normal(generator);
  a.c[0] = constant;
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
      const double x = at(a, t), y = at(b, t);
      CHECK(std::abs(at(product, t) - x * y) <= product.remainder);
      CHECK(std::abs(at(sum, t) - (x + y)) <= sum.remainder);
      CHECK(std::abs(at(root, t) - 1.0 / std::sqrt(x)) <= root.remainder);
      CHECK(std::abs(at(one_over, t) - 1.0 / x) <= one_over.remainder);
      CHECK(std::abs(at(sin, t) - std::sin(y)) <= sin.remainder);
      CHECK(std::abs(at(cos, t) - std::cos(y)) <= cos.remainder);
      const Interval interval = range(product);
      CHECK(interval.low <= x * y);
      CHECK(interval.high >= x * y);
    }
  }
}

TEST_CASE("an argument that may reach zero has no inverse and says so") {
  TaylorModel a;
  a.c[0] = 1.0;
  a.c[1] = 0.9;
  CHECK_FALSE(std::isfinite(inverse(a).remainder));
  const Interval interval = range(inverse(a) * a);
  CHECK(interval.high == std::numeric_limits<double>::infinity());
  CHECK(interval.low == -std::numeric_limits<double>::infinity());
}

}  // namespace halfroll::planner
