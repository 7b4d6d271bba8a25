#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cstdlib>

#include "kernel/block_tridiagonal.hpp"

namespace halfroll::planner {
namespace {

constexpr int kB = 3, kR = 2, kNodes = 7;
using System = BlockTridiagonal<kB, kR>;

System::Rows random_rows(int node) {
  System::Rows rows = System::Rows::Random();
  if (node == 0) rows.leftCols<kB>().setZero();
  if (node == kNodes - 1) rows.middleCols<kB>(2 * kB).setZero();
  return rows;
}

}  // namespace

TEST_CASE("a block-tridiagonal system has the solution of the dense one, singular diagonal blocks or not") {
  std::srand(1);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kB * kNodes, kB * kNodes), right(kB * kNodes, kR);
  System system(kNodes);
  for (int k = 0; k < kNodes; ++k) {
    System::Rows rows = random_rows(k);
    if (k == 2 || k == 5) rows.middleCols<kB>(kB).setZero();
    for (int other = std::max(0, k - 1); other <= std::min(kNodes - 1, k + 1); ++other) {
      dense.block<kB, kB>(kB * k, kB * other) = rows.middleCols<kB>(kB * (other - k + 1));
    }
    right.middleRows<kB>(kB * k) = rows.middleCols<kR>(3 * kB);
    REQUIRE(system.push(rows));
  }
  const Eigen::MatrixXd expected = dense.fullPivLu().solve(right);
  Eigen::MatrixXd found(kB * kNodes, kR);
  REQUIRE(system.solve([&](int k, const System::Unknowns& x) { found.middleRows<kB>(kB * k) = x; }));
  CHECK(found.isApprox(expected, 1e-10));
}

TEST_CASE("two equations that say the same are found out") {
  System system(kNodes);
  bool solved = true;
  for (int k = 0; k < kNodes && solved; ++k) {
    System::Rows rows = random_rows(k);
    if (k == 3) rows.row(1) = rows.row(0);
    solved = system.push(rows);
  }
  CHECK_FALSE((solved && system.solve([](int, const System::Unknowns&) {})));
}

}  // namespace halfroll::planner
