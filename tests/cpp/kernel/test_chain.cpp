#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <random>

#include "kernel/chain.hpp"

namespace halfroll::planner {
namespace {

/// Where an unknown of the front of a piece is in the whole system; -1: nowhere.
int global(const Chain& chain, const std::vector<int>& group, int piece, int place) {
  if (place < kTimes) return chain.node(piece) + place;
  for (int g = group[piece] - 1; g <= group[piece] + 1; ++g) {
    if (g >= 0 && g < chain.groups() && Chain::place(g) == place) return chain.time(g);
  }
  return -1;
}

}  // namespace

TEST_CASE("elimination along time solves what a dense factorisation solves") {
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  for (const std::vector<int>& group :
       {std::vector<int>{0}, {0, 0}, {0, 1}, {0, 0, 1, 1, 1, 2, 3}, {0, 1, 2, 3, 4, 5}}) {
    Chain chain(group);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(chain.size(), chain.size());
    for (int k = 0; k < chain.pieces(); ++k) {
      Front& front = chain.piece(k);
      front = {};
      for (int i = 0; i < kFrontUsed; ++i) {
        for (int j = i; j < kFrontUsed; ++j) {
          const int row = global(chain, group, k, i), column = global(chain, group, k, j);
          if (row < 0 || column < 0) continue;
          front(i, j) = i == j ? 40.0 : normal(generator);
          dense(row, column) += front(i, j);
          if (i != j) dense(column, row) += front(i, j);
        }
      }
    }
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(chain.size(), -1.0, 2.0);
    REQUIRE(chain.factorise(0.5));
    dense.diagonal().array() += 0.5;
    CHECK((chain.solve(b) - dense.llt().solve(b)).norm() < 1e-13);
  }
}

TEST_CASE("where the matrix is indefinite only the unknowns of that piece are damped") {
  Chain chain({0, 1});
  for (int k = 0; k < 2; ++k) {
    Front& front = chain.piece(k) = {};
    for (int i = 0; i < kFrontUsed; ++i) front(i, i) = 1.0;
  }
  chain.piece(0)(0, 1) = 2.0;
  REQUIRE(chain.factorise(0.0));
  const Eigen::VectorXd x = chain.solve(Eigen::VectorXd::Ones(chain.size()));
  CHECK(x[chain.node(0)] > 0.0);
  CHECK(x[chain.node(0)] < 0.5);
  CHECK(x[chain.node(1)] == doctest::Approx(0.5));  // of two pieces
  CHECK(x[chain.node(2)] == doctest::Approx(1.0));
}

}  // namespace halfroll::planner
