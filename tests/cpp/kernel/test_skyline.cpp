#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <random>

#include "kernel/skyline.hpp"

namespace halfroll::planner {

TEST_CASE("the envelope factorisation solves what a dense one solves") {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  const int n = 60;
  std::vector<int> first(n);
  for (int i = 0; i < n; ++i) first[i] = i % 10 == 9 ? std::max(0, i - 25) : std::max(0, i - 6);
  Skyline skyline(first);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = first[i]; j <= i; ++j) {
      const double entry = i == j ? 40.0 : normal(generator);
      skyline.add(i, j, entry);
      dense(i, j) = dense(j, i) = entry;
    }
  }
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
  REQUIRE(skyline.factorise(0.5));
  dense.diagonal().array() += 0.5;
  CHECK((skyline.solve(b) - dense.llt().solve(b)).norm() < 1e-14);
}

TEST_CASE("an indefinite matrix is refused, and accepted once it is damped") {
  Skyline skyline({0, 0});
  skyline.add(0, 0, 1.0);
  skyline.add(1, 0, 2.0);
  skyline.add(1, 1, 1.0);
  CHECK_FALSE(skyline.factorise(0.0));
  CHECK(skyline.factorise(2.0));
}

}  // namespace halfroll::planner
