// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/closure_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace hybrid {
namespace {

constexpr std::size_t kAisle = 30;  // poses in one
constexpr double kStep = 0.7;       // m
constexpr double kBetween = 5.4;    // from one aisle to the next [m]
constexpr std::size_t kAcross = 8;  // steps from one to the next
constexpr std::size_t kEvery = 3;   // steps between searches

/// Of a motion with independent errors of position [m] and turn [rad].
template <class Pose>
typename Pose::Jacobian covariance_of(double position, double turn) {
  typename Pose::Jacobian C = turn * turn * Pose::Jacobian::Identity();
  C.diagonal().template head<SurfaceMatch<Pose>::kSpace>().setConstant(position * position);
  return C;
}

SE2 planar(double x, double y, double yaw, const SE2& /*kind*/) {
  return {x, y, yaw};
}

SE3 planar(double x, double y, double yaw, const SE3& /*kind*/) {
  return {Eigen::Vector3d(x, y, 0.0), SO3::exp(Eigen::Vector3d(0.0, 0.0, yaw))};
}

/// The way of a robot along one aisle between equal rows, to the next one, and back beside it.
template <class Pose>
std::vector<Pose> way_through_rows() {
  std::vector<Pose> way;
  for (std::size_t i = 0; i < kAisle; ++i) way.push_back(planar(kStep * double(i), 0, 0, Pose()));
  const double end = kStep * double(kAisle - 1);
  for (std::size_t i = 1; i < kAcross; ++i) {
    way.push_back(planar(end, kBetween * double(i) / double(kAcross), M_PI / 2.0, Pose()));
  }
  for (std::size_t i = 0; i < kAisle; ++i) {
    way.push_back(planar(end - kStep * double(i), kBetween, M_PI, Pose()));
  }
  return way;
}

/// The same motion with an error drawn from that covariance, which is diagonal.
template <class Pose>
Pose noisy(const Pose& motion, const typename Pose::Jacobian& covariance, std::mt19937& random) {
  std::normal_distribution<double> normal;
  typename Pose::Tangent noise;
  for (int i = 0; i < Pose::kDim; ++i) noise[i] = std::sqrt(covariance(i, i)) * normal(random);
  return motion * Pose::exp(noise);
}

struct Mapped {
  std::size_t accepted = 0, closures = 0;
  double error = 0.0;  // of the last position [m]
};

/// Maps the way through the rows. In the second aisle each search finds one place in the first,
/// where the robot would be if it were so far beside its true place.
template <class Pose>
Mapped map_rows(double off, unsigned seed) {
  const std::vector<Pose> way = way_through_rows<Pose>();
  const auto step_covariance = covariance_of<Pose>(0.1, 0.003);
  const auto match_covariance = covariance_of<Pose>(0.05, 0.01);
  std::mt19937 random(seed);
  ClosureGraph<Pose> graph{OnlineSelectionOptions()};
  graph.begin();
  for (std::size_t k = 1; k < way.size(); ++k) {
    const Pose motion = noisy(way[k - 1].between(way[k]), step_covariance, random);
    std::vector<PlaceClosure<Pose>> found;
    if (k >= kAisle + kAcross - 1 && k % kEvery == 0) {
      PlaceClosure<Pose> closure;
      closure.from = way.size() - 1 - k;
      closure.to = k;
      const Pose there = planar(0.0, -off, 0.0, Pose()) * way[k];
      closure.pose = {noisy(way[closure.from].between(there), match_covariance, random),
                      match_covariance};
      found.push_back(closure);
    }
    graph.add(graph.step(k, graph.pose(k - 1) * motion, {{k - 1, {motion, step_covariance}}}),
              found);
  }
  graph.finish();
  Mapped out;
  out.closures = graph.closures().size();
  for (std::size_t c = 0; c < out.closures; ++c) {
    out.accepted += graph.selection().status(c) == ClosureStatus::kAccepted ? 1 : 0;
  }
  out.error = (graph.pose(way.size() - 1).translation() - way.back().translation()).norm();
  return out;
}

template <class Pose>
void expect_two_rows() {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Mapped false_ones = map_rows<Pose>(kBetween, seed);
    EXPECT_EQ(false_ones.accepted, 0U) << "of " << false_ones.closures << ", seed " << seed;
    EXPECT_LT(false_ones.error, 0.5 * kBetween) << "seed " << seed;
    const Mapped true_ones = map_rows<Pose>(0.0, seed);
    EXPECT_EQ(true_ones.accepted, true_ones.closures) << "seed " << seed;
    EXPECT_LT(true_ones.error, 0.2) << "seed " << seed;
  }
}

// Walls and floor fit in the wrong row as well as in the right one: only the position tells.
TEST(ClosureGraph, EqualRowsDoNotBecomeOneByScans) {
  expect_two_rows<SE2>();
}

TEST(ClosureGraph, EqualRowsDoNotBecomeOneByClouds) {
  expect_two_rows<SE3>();
}

}  // namespace
}  // namespace hybrid
