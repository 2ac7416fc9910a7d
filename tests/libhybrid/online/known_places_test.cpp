// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/known_places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/online/closure_graph.h"
#include "libhybrid/online/join_graph.h"
#include "libhybrid/online/place_chain.h"

namespace hybrid {
namespace {

constexpr std::size_t kPlaces = 12;
constexpr double kApart = 3;      // from one place to the next [m]
constexpr double kOfFirst = 0.4;  // sigma of the first place [m]
constexpr double kBeside = 0.02;  // sigma of the next one beside it [m]

Eigen::Matrix3d squared(double position, double turn) {
  return Eigen::Vector3d(position, position, turn).cwiseAbs2().asDiagonal();
}

/// A drive along an arc, as a graph of its places.
struct Drive {
  Values values;
  HybridGraph graph;

  Drive() {
    values.insert(Key('x', 0), SE2(5, -2, 0.4));
    graph.add(std::make_shared<Prior<SE2>>(Key('x', 0), SE2(5, -2, 0.4),
                                           Noise::covariance(squared(kOfFirst, 0.02))));
    const SE2 step(kApart, 0.1, 0.3);
    for (std::size_t i = 1; i < kPlaces; ++i) {
      values.insert(Key('x', i), values.at<SE2>(Key('x', i - 1)) * step);
      graph.add(std::make_shared<Between<SE2>>(Key('x', i - 1), Key('x', i), step,
                                               Noise::covariance(squared(kBeside, 0.002))));
    }
  }

  ContinuousMarginals marginals() const { return ContinuousMarginals(graph, {values, {}}); }

  std::vector<KnownPlace<SE2>> places() const {
    const ContinuousMarginals all = marginals();
    PlaceChain<SE2> chain(
        values, [](Key) { return true; },
        [&](const std::vector<Key>& keys, const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
          return J * all.joint_covariance(keys) * J.transpose();
        });
    std::vector<KnownPlace<SE2>> out;
    for (std::size_t i = 0; i < kPlaces; ++i) {
      out.emplace_back(values.at<SE2>(Key('x', i)), all.covariance(Key('x', i)));
      out.back().parent = chain.next(Key('x', i));
    }
    return out;
  }
};

// Of a drive without loops the tree of places is its joint density, whichever places come first.
TEST(KnownPlaces, HaveTheJointDensityOfTheirMap) {
  const Drive drive;
  const std::vector<KnownPlace<SE2>> places = drive.places();
  EXPECT_FALSE(places.front().parent);
  for (const std::vector<std::size_t>& order :
       {std::vector<std::size_t>{11, 4}, {2, 4, 11}, {4, 11, 0}}) {
    Delta change;
    for (const std::size_t i : order) insert_place(places, i, {}, change);
    EXPECT_EQ(change.continuous.size(), kPlaces);
    HybridGraph graph;
    for (const ContinuousFactorPtr& factor : change.continuous) graph.add(factor);
    const ContinuousMarginals marginals(graph, {change.values, {}});
    const Eigen::MatrixXd found = marginals.joint_covariance({place_key(4), place_key(11)});
    const Eigen::MatrixXd truth = drive.marginals().joint_covariance({Key('x', 4), Key('x', 11)});
    EXPECT_LT((found - truth).norm(), 1e-9 * truth.norm());
  }
}

// A robot that has seen one place knows where to look for the next ones.
TEST(KnownPlaces, AreKnownBesideThoseThatWereSeen) {
  const Drive drive;
  ClosureGraph<SE2> graph{OnlineSelectionOptions()};
  const SE2 first = drive.values.at<SE2>(Key('x', 2));
  graph.adopt(drive.places(), {first, squared(0.5, 0.05)});
  graph.begin();
  const auto sigma = [&](std::size_t place) {
    return std::sqrt(graph.from_place(place, 0).covariance.topLeftCorner(2, 2).trace());
  };
  EXPECT_GT(sigma(4), kOfFirst);
  PlaceClosure<SE2> closure;
  closure.from = 2;
  closure.is_known = true;
  closure.pose = {SE2(), squared(0.01, 0.001)};
  for (int times = 0; times < 3; ++times) graph.add({}, {closure});
  EXPECT_LT(sigma(2), 2 * kBeside);
  EXPECT_LT(sigma(4), 4 * kBeside);
  EXPECT_LT(sigma(9), kOfFirst);
  const SE2 seen = graph.from_place(4, 0).motion;
  EXPECT_LT(drive.values.at<SE2>(Key('x', 4)).between(first).between(seen).log().norm(), 0.05);
}

// Two maps that share a place: each keeps what its places have in common, and the second is known
// beside the first.
TEST(KnownPlaces, OfTwoMapsAreJoined) {
  const Drive drive;
  std::vector<StoredPlace<SE2>> places;
  for (const KnownPlace<SE2>& place : drive.places()) places.push_back({place, {}, false});
  const SE2 truth(10, 4, 1);
  std::vector<StoredPlace<SE2>> second = places;
  for (StoredPlace<SE2>& place : second) {
    place.T_map_anchor.motion = truth.inverse() * place.T_map_anchor.motion;
  }
  const auto match = [](std::size_t i, std::size_t k, const UncertainMotion&) {
    std::vector<UncertainMotion> found;
    if (i == k && k > 7) found.push_back({SE2(), squared(0.01, 0.001)});
    return found;
  };
  const JoinGraph<SE2> graph(places, second, {truth * SE2(0.2, 0.1, 0.01), squared(0.5, 0.05)},
                             second[9].T_map_anchor.motion.translation(), match, {4.0, 4});
  EXPECT_EQ(graph.accepted().size(), 4U);
  const std::vector<KnownPlace<SE2>> all = graph.anchors();
  ASSERT_EQ(all.size(), 2 * kPlaces);
  ASSERT_TRUE(all[kPlaces].parent);
  EXPECT_GE(all[kPlaces].parent->place, 8U);
  EXPECT_LT(all[kPlaces].parent->place, kPlaces);
  EXPECT_LT(std::sqrt(all[kPlaces].parent->covariance(0, 0)), kOfFirst);
  for (std::size_t k = 1; k < kPlaces; ++k) {
    ASSERT_TRUE(all[kPlaces + k].parent);
    EXPECT_EQ(all[kPlaces + k].parent->place, kPlaces + k - 1);
    EXPECT_LT(all[k].motion.between(all[kPlaces + k].motion).log().norm(), 0.1);
  }
}

}  // namespace
}  // namespace hybrid
