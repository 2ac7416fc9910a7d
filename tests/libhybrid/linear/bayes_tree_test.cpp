// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/bayes_tree.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cstdlib>

#include "tests/support/dense_tree.h"

namespace hybrid {
namespace {

using testing::Dense;
using testing::Pair;
using testing::Random;

/// Sequences of changes per test; HYBRID_TEST_CASES in the environment multiplies them.
int cases(int base) {
  const char* times = std::getenv("HYBRID_TEST_CASES");
  return times == nullptr ? base : base * std::max(1, std::atoi(times));
}

/// Smallest eigenvalue by largest after scaling to a unit diagonal; zero for an empty row.
double conditioning(const Eigen::MatrixXd& information) {
  if (information.size() == 0) return 1.0;
  const Eigen::VectorXd diagonal = information.diagonal();
  if (diagonal.minCoeff() <= 0.0) return 0.0;
  const Eigen::VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      scale.asDiagonal() * information * scale.asDiagonal(), Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().minCoeff() / eigen.eigenvalues().maxCoeff();
}

/// What a chain knows of its end may be lost in rounding beside what its end knows of its
/// neighbour.
TEST(BayesTree, LiftedPivotsHoldThePresentSteps) {
  BayesTree tree;
  tree.add_variable(0, 1);
  tree.add_variable(1, 1);
  const auto fill = [&tree](int factor, const std::vector<double>& packed) {
    std::copy(packed.begin(), packed.end(), tree.hessian(factor));
  };
  fill(tree.add_factor({0}), {1, -1, 1});                       // x_0 = 1
  fill(tree.add_factor({0, 1}), {1e14, -1e14, 0, 1e14, 0, 0});  // x_1 = x_0, far more precisely
  const auto is_determined = [](const std::vector<int>&) { return true; };
  double last = 0.0;
  for (int round = 0; round < 1000; ++round) {
    for (int v : {0, 1}) tree.eliminate_again(v);
    ASSERT_LT(tree.eliminate({1}, is_determined).singular, 0);
    tree.solve(0.0);
    tree.commit();
    // Damped, yet no step leads back and none beyond the solution.
    EXPECT_GE(tree.system().delta(1)[0], last - 1e-9);
    last = tree.system().delta(1)[0];
    if (round == 0) {
      EXPECT_LT(last, 0.5);
    }
  }
  EXPECT_NEAR(last, 1.0, 0.05);
  EXPECT_NEAR(tree.system().delta(0)[0], last, 1e-9);
}

/// A tree of scalar variables with factors of given Hessians.
struct Springs {
  explicit Springs(int variables) {
    for (int v = 0; v < variables; ++v) tree.add_variable(v, 1);
  }
  void add(const std::vector<int>& variables, const std::vector<double>& packed) {
    factors.push_back(tree.add_factor(variables));
    std::copy(packed.begin(), packed.end(), tree.hessian(factors.back()));
  }
  void solve(const std::vector<int>& last, const Bend& bend) {
    ASSERT_LT(tree.eliminate(last).singular, 0);
    tree.solve(1e-9, bend);
    tree.commit();
  }
  double cost() const {
    double sum = 0.0;
    for (int f : factors) sum += tree.system().linear_cost(f);
    return sum;
  }

  BayesTree tree;
  std::vector<int> factors;
};

/// A stiff chain, of which a share of what its factors may cost is far more than what a pull at its
/// end brings.
TEST(BayesTree, WhatStaysCostsNoMoreThanHalfOfWhatNewStepsBring) {
  constexpr int kLength = 1000;
  Springs springs(kLength);
  springs.add({0}, {100, 0, 0});
  for (int v = 1; v < kLength; ++v) springs.add({v - 1, v}, {100, -100, 0, 100, 0, 0});
  springs.solve({kLength - 1}, {});
  springs.add({kLength - 1}, {1, -3, 9});  // x = 3
  const double before = springs.cost();
  const double promised = before - 4.5 / (1 + 10);  // two springs in a row, of 1 and .1
  springs.solve({kLength - 1}, {0.0, 1.0});
  EXPECT_GE(before - springs.cost(), 0.5 * promised);
  EXPECT_NEAR(before, 4.5, 1e-9);
}

/// A soft chain of which each link sees one more variable: what it costs that the chain stays while
/// that one moves is little for each link, and much for all of them.
TEST(BayesTree, WhatStaysIsCountedInAllThatSeeIt) {
  constexpr int kLength = 1000, kSeen = kLength;
  Springs springs(kSeen + 1);
  springs.add({0}, {1e-3, 0, 0});
  for (int v = 0; v < kLength; ++v) {
    springs.add({v, kSeen}, {1, -1, 0, 1, 0, 0});
    if (v > 0) springs.add({v - 1, v}, {0.1, -0.1, 0, 0.1, 0, 0});
  }
  springs.solve({kLength - 1, kSeen}, {});
  springs.add({kSeen}, {100, -300, 900});  // x = 3
  const double before = springs.cost();
  springs.solve({kLength - 1, kSeen}, {0.0, 10.0});
  EXPECT_NEAR(before, 450, 1e-9);
  EXPECT_LT(springs.cost(), 0.5 * before + 0.01);  // that of all in one place is 0.0045
}

TEST(BayesTree, EqualsDenseOverRandomChanges) {
  int singular = 0;
  for (int seed = 1; seed <= cases(150); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Pair pair(seed);
    for (int step = 0; step < 15; ++step) {
      const Pair committed = pair;
      const std::vector<double> before = pair.state();
      pair.change();
      const double condition = conditioning(pair.dense(true).information);
      const EliminationReport report = pair.eliminate();
      if (condition > 1e-8) {
        ASSERT_LT(report.singular, 0) << "step " << step;
      }
      if (condition < 1e-15) {
        ASSERT_GE(report.singular, 0) << "step " << step;
      }
      if (report.singular >= 0) {
        ++singular;
        pair.roll_back(committed);
        ASSERT_EQ(pair.state(), before) << "step " << step;
        continue;
      }
      pair.tree().solve(0.0);
      pair.commit();
      if (condition > 1e-8 && !pair.empty()) {
        const double dense =
            pair.dense(false).information.llt().matrixLLT().diagonal().array().log().sum();
        EXPECT_NEAR(pair.tree().log_determinant(), 2.0 * dense, 1e-6);
      }
      if (conditioning(pair.dense(false).information) < 1e-8 || pair.empty()) continue;
      pair.expect_solution(1e-6);
      if (step % 5 == 4) {
        pair.expect_covariances(1e-7);
        pair.disturb();
        pair.tree().solve(0.0);
        pair.expect_solution(1e-6);
      }
      if (::testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(singular, 50);
}

/// Some changes in a row, each solved, eliminated where that is needed; one that is refused ends
/// them.
void try_changes(Pair& pair, int count) {
  for (int k = 0; k < count; ++k) {
    k % 2 == 1 && !pair.empty() ? pair.grow() : pair.change();
    if (!pair.defer() && pair.eliminate().singular >= 0) return;
    pair.tree().solve(k % 2 == 0 ? 0.0 : 1e-3);
    if (!pair.empty() && k % 3 == 0) pair.disturb();
  }
}

TEST(BayesTree, RollBackTakesEverythingBackAndLeavesNoTrace) {
  for (int seed = 1; seed <= cases(60); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Pair pair(seed);
    for (int step = 0; step < 10; ++step) {
      const Pair committed = pair;
      const std::vector<double> before = pair.state();
      try_changes(pair, 1 + step % 4);
      if (step % 3 == 0) pair.change();  // not eliminated
      pair.roll_back(committed);
      ASSERT_EQ(pair.state(), before);

      // What comes next is the same for a tree that never tried.
      Pair twin = committed;
      for (Pair* each : {&pair, &twin}) {
        each->seed(1000 * seed + step);
        try_changes(*each, 2);
      }
      ASSERT_EQ(pair.state(), twin.state());
      pair.roll_back(committed);
      pair.change();
      if (pair.eliminate().singular >= 0) {
        pair.roll_back(committed);
        continue;
      }
      pair.tree().solve(0.0);
      pair.commit();
      if (pair.empty()) continue;
      if (conditioning(pair.dense(false).information) > 1e-8) pair.expect_solution(1e-6);
      if (::testing::Test::HasFailure()) return;
    }
  }
}

TEST(BayesTree, WhatIsPendingIsAsWhatIsEliminated) {
  int deferred = 0, refused = 0, most = 0;
  for (int seed = 1; seed <= cases(100); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Pair pair(seed);
    for (int step = 0; step < 25; ++step) {
      const Pair committed = pair;
      const bool grows = step % 9 != 0 && !pair.empty();
      grows ? pair.grow() : pair.change();
      const bool is_pending = pair.defer();
      if (!is_pending && pair.eliminate().singular >= 0) {
        pair.roll_back(committed);
        continue;
      }
      pair.tree().solve(0.0);
      pair.commit();
      if (pair.empty()) continue;
      deferred += is_pending ? 1 : 0;
      refused += grows && !is_pending ? 1 : 0;
      most = std::max(most, pair.tree().pending());
      const Eigen::MatrixXd information = pair.dense(false).information;
      if (conditioning(information) < 1e-6) break;
      const double dense = information.llt().matrixLLT().diagonal().array().log().sum();
      EXPECT_NEAR(pair.tree().log_determinant(), 2.0 * dense, 1e-6);
      pair.expect_solution(1e-6);
      if (step % 3 == 0) pair.expect_covariances(1e-7);
      if (::testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(deferred, 1000);
  EXPECT_LT(refused, deferred / 50);  // what rounding would lose
  EXPECT_GT(most, 5);
}

TEST(BayesTree, APendingFactorMaySayNothing) {
  Springs springs(2);
  springs.add({0}, {1, -1, 1});
  springs.add({0, 1}, {1, -1, 0, 1, 0, 0});
  springs.solve({1}, {});
  springs.add({0, 1}, {0, 0, 0, 0, 0, 0});
  ASSERT_TRUE(springs.tree.defer(1e9));
  springs.add({1}, {1, -3, 9});  // x = 3
  ASSERT_TRUE(springs.tree.defer(1e9));
  springs.tree.solve(0.0);
  EXPECT_EQ(springs.tree.pending(), 2);
  EXPECT_NEAR(springs.tree.system().delta(1)[0], 1.0 + 2.0 * 2 / 3, 1e-12);
  const Eigen::MatrixXd P = springs.tree.covariances().joint({1});
  EXPECT_NEAR(P(0, 0), 2.0 / 3, 1e-12);
}

/// Poses on a line, each tied to the one before, the first one held: the last is known n times less
/// well than its own factor says.
TEST(BayesTree, AsksWhetherWhatIsLostInRoundingIsDetermined) {
  BayesTree tree;
  const auto add = [&](int v, double weight) {
    tree.add_variable(v, 1);
    const int f = v == 0 ? tree.add_factor({0}) : tree.add_factor({v - 1, v});
    double* h = tree.hessian(f);
    h[0] = weight;
    if (v == 0) return;
    h[1] = -weight;
    h[3] = weight;
  };
  add(0, 1e-13);  // far less than the rest
  add(1, 1.0);
  EXPECT_GE(tree.eliminate({1}).singular, 0);
  std::vector<int> asked;
  const EliminationReport report = tree.eliminate({1}, [&](const std::vector<int>& variables) {
    asked = variables;
    return true;
  });
  EXPECT_LT(report.singular, 0);
  EXPECT_EQ(asked, std::vector<int>{1});
  tree.solve(0.0);
  EXPECT_TRUE(std::isfinite(tree.system().delta(1)[0]));
  tree.roll_back({});
  add(0, 1e-6);
  add(1, 1.0);
  EXPECT_LT(tree.eliminate({1}).singular, 0);
}

TEST(BayesTree, BytesDoNotGrowWithRepeatedChanges) {
  BayesTree tree;
  tree.add_variable(0, 3);
  const auto unit = [&](int f) {
    for (int i = 0; i < 3; ++i) packed_column(tree.hessian(f), 4, i)[i] = 1.0;
  };
  unit(tree.add_factor({0}));
  tree.eliminate({});
  tree.commit();
  BayesTree::Mark before;
  std::size_t bytes = 0;
  for (int k = 0; k < 10000; ++k) {
    const int f = tree.add_factor({0});
    unit(f);
    tree.eliminate({});
    tree.remove_factor(f);
    tree.eliminate({});
    tree.solve(0.0);
    if (k % 2 == 0) {
      tree.commit();
      before = tree.mark();
    } else {
      tree.roll_back(before);
    }
    if (k == 10) bytes = tree.bytes();
  }
  EXPECT_LE(tree.bytes(), bytes);
}

}  // namespace
}  // namespace hybrid
