// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/certificate.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

using worlds::World;

/// What Levenberg-Marquardt finds from some poses, and what is proven of that.
struct Candidate : Certificate {
  double stated_cost = 0.0;  // of the factors as they are
};

Candidate certify_from(const PoseGraph& graph, const Values& start) {
  const std::vector<ContinuousFactorPtr> factors = to_factors(graph, start);
  HybridGraph all;
  for (const ContinuousFactorPtr& factor : factors) all.add(factor);
  SolverOptions options;
  options.max_iterations = 60;
  options.threads = 1;
  const SolverResult found = levenberg_marquardt(all, {start, {}}, options);
  return {certify(factors, found.values), found.report.final_cost()};
}

TEST(Certificate, NoneIsFalseOnAThousandGraphs) {
  int verified = 0, from_scrambled = 0;
  for (unsigned k = 0; k < 1000; ++k) {
    World world = worlds::small_world(k, 0.05 * (k % 7));
    const Candidate planted = certify_from(world.graph, world.truth);
    scramble(world, k);
    const Candidate other = certify_from(world.graph, world.graph.values);
    const double lowest = std::min(planted.cost, other.cost);
    const double stated = std::min(planted.stated_cost, other.stated_cost);
    for (const Candidate* c : {&planted, &other}) {
      if (!c->verified) continue;
      EXPECT_LE(c->cost, lowest * (1 + 2e-6)) << "graph " << k;
      EXPECT_LE(c->stated_cost, stated * (1 + 1e-3)) << "graph " << k;
      EXPECT_LE(c->relative_gap, 1e-6);
    }
    verified += planted.verified;
    from_scrambled += other.verified;
  }
  // Most planted optima are verified; a random start ends in a local minimum more often than not.
  EXPECT_GT(verified, 700);
  EXPECT_LT(from_scrambled, 500);
}

TEST(Certificate, AnExactGraphIsVerified) {
  const World world = worlds::torus(5, 8, {1e-6, 1e-6}, 3);
  const Certificate certificate = certify_from(world.graph, world.truth);
  EXPECT_TRUE(certificate.verified) << certificate.message;
  constexpr double kWeight = 1e12;  // 1 / sigma^2, by which the matrix scales
  EXPECT_GT(certificate.min_eigenvalue / kWeight, -1e-10);
}

TEST(Certificate, ALoopOnceTooOftenIsRefused) {
  // Twelve steps of 30 degrees, estimated as if they had been of 60: wound twice.
  PoseGraph graph;
  const Noise noise = Noise::isotropic(3, 0.3);
  Values twice;
  for (int i = 0; i < 12; ++i) {
    graph.poses2.push_back({Key('x', i), Key('x', (i + 1) % 12), SE2(1, 0, M_PI / 6), noise});
    twice.insert(Key('x', i), SE2(std::sin(M_PI / 3 * i), -std::cos(M_PI / 3 * i), M_PI / 3 * i));
  }
  const Certificate wound = certify_from(graph, twice);
  EXPECT_FALSE(wound.verified);
  EXPECT_LT(wound.min_eigenvalue, -0.1);
  EXPECT_GT(wound.relative_gap, 0.1);
  const Certificate once = certify_from(graph, initialize_from_odometry(graph));
  EXPECT_TRUE(once.verified) << once.min_eigenvalue;
  EXPECT_LT(once.cost, 1e-12);  // of which rounding is a large share
  EXPECT_EQ(once.relative_gap, 0.0);
}

TEST(Certificate, OnlyIsotropicNoiseWithoutLossesIsProven) {
  const World world = worlds::torus(3, 5, {0.1, 0.05}, 1);
  const auto certified = [&](const Eigen::VectorXd& scale, const Loss& loss) {
    const Key first = world.graph.poses3.front().from;
    std::vector<ContinuousFactorPtr> factors{
        std::make_shared<Prior<SE3>>(first, world.truth.at<SE3>(first), Noise::unit(6))};
    for (const auto& edge : world.graph.poses3) {
      const SE3::Jacobian information =
          scale.asDiagonal() * edge.noise.information() * scale.asDiagonal();
      factors.push_back(std::make_shared<Between<SE3>>(edge.from, edge.to, edge.measured,
                                                       Noise::information(information), loss));
    }
    SolverOptions options;
    options.threads = 1;
    const SolverResult found =
        levenberg_marquardt(HybridGraph(factors), {world.truth, {}}, options);
    return certify(factors, found.values);
  };
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(6);
  const Certificate proven = certified(scale, {});
  EXPECT_TRUE(proven.verified && proven.isotropic_verified) << proven.message;
  EXPECT_LT(proven.stated_gap, 0.01);
  const Certificate robust = certified(scale, Loss::huber());
  EXPECT_FALSE(robust.verified);
  EXPECT_EQ(robust.stated_gap, 1.0);
  scale[1] = 2.0;
  const Certificate anisotropic = certified(scale, {});
  EXPECT_FALSE(anisotropic.verified);
  EXPECT_TRUE(anisotropic.isotropic_verified) << anisotropic.message;
  EXPECT_EQ(anisotropic.stated_gap, 1.0);
  EXPECT_NE(anisotropic.message, "");
}

TEST(Certificate, NothingToCertifyIsAnError) {
  EXPECT_THROW(certify({}, {}), Error);
  const World world = worlds::torus(3, 5, {0.1, 0.1}, 1);
  EXPECT_THROW(certify(to_factors(world.graph, world.truth), Values()), Error);
}

}  // namespace
}  // namespace hybrid
