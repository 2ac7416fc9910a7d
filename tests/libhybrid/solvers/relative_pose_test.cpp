// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A user's factor that measures a motion counts wherever relative poses do, also when wrapped.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/closures/kernel.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/solvers/chordal.h"

namespace hybrid {
namespace {

/// A motion of which the residual is the plain difference of the storage, as no factor of ours.
class UserMotion : public FactorOf<3, SE2, SE2> {
 public:
  UserMotion(Key a, Key b, const SE2& measured, const Noise& noise)
      : FactorOf({a, b}, noise), inner_(a, b, measured, noise) {}
  std::string name() const override { return "user's motion"; }
  std::optional<RelativePose<SE2>> relative_pose_2d() const override {
    return inner_.relative_pose_2d();
  }
  Residual evaluate(const SE2& a, const SE2& b, Jacobian<SE2>* Ja,
                    Jacobian<SE2>* Jb) const override {
    return inner_.evaluate(a, b, Ja, Jb);
  }

 private:
  Between<SE2> inner_;
};

ContinuousFactorPtr wrapped(int how, Key a, Key b, const SE2& motion) {
  const Noise noise = Noise::isotropic(3, 0.1);
  auto factor = std::make_shared<UserMotion>(a, b, motion, noise);
  if (how == 1) return std::make_shared<Inflated>(factor, 4.0);
  if (how == 2) {
    const Kernel kernel{[](double s) { return s; }, [](double) { return 1.0; }};
    return std::make_shared<KernelFactor>(factor, kernel);
  }
  return factor;
}

class RelativePoseTest : public ::testing::TestWithParam<int> {};

TEST_P(RelativePoseTest, ChordalInitialisationUsesIt) {
  std::vector<ContinuousFactorPtr> factors;
  Values truth, start;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / 12;
    truth.insert(Key('x', i), SE2(5 * std::cos(angle), 5 * std::sin(angle), angle + M_PI / 2));
    start.insert(Key('x', i), i == 0 ? truth.at<SE2>(Key('x', 0)) : SE2());
  }
  factors.push_back(std::make_shared<Prior<SE2>>(Key('x', 0), truth.at<SE2>(Key('x', 0)),
                                                 Noise::isotropic(3, 0.01)));
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Key a('x', i), b('x', (i + 1) % 12);
    factors.push_back(wrapped(GetParam(), a, b, truth.at<SE2>(a).between(truth.at<SE2>(b))));
  }
  const Values found = chordal_initialization(factors, start);
  for (Key key : truth.keys()) {
    EXPECT_LT((found.at<SE2>(key).matrix() - truth.at<SE2>(key).matrix()).norm(), 1e-6) << key;
  }
}

TEST_P(RelativePoseTest, IsExportedWithItsInformation) {
  HybridGraph graph;
  Estimate estimate;
  estimate.values.insert(Key('x', 0), SE2());
  estimate.values.insert(Key('x', 1), SE2(1, 0, 0.2));
  graph.add(wrapped(GetParam(), Key('x', 0), Key('x', 1), SE2(1, 0, 0.2)));
  const PoseGraph exported = to_pose_graph(graph, estimate);
  ASSERT_EQ(exported.poses2.size(), 1u);
  const double variance = GetParam() == 1 ? 0.04 : 0.01;
  const Eigen::MatrixXd R = exported.poses2[0].noise.sqrt_information();
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity() / variance).norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Wrapped, RelativePoseTest, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace hybrid
