// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid::bench {

using worlds::World;

constexpr worlds::Sigmas kRoad{0.05, 0.01};    // of relative poses in the plane, per metre driven
constexpr worlds::Sigmas kFlight{0.05, 0.02};  // of relative poses in space
constexpr double kSightSigma = 0.1;            // of landmarks [m]
constexpr int kVisits = 4;                     // mean number of visits to a place
constexpr int kPosesBetween = 10;              // at least so many between the two ends of a closure

/// A car that drives through a square town of streets, one pose a metre, and turns at random at
/// crossings.
class Drive {
 public:
  /// Crossings are `block` [m] apart; the town has the size in which `poses` visit each place
  /// kVisits times on average.
  Drive(int poses, int block, std::uint64_t seed) : block_(block), random_(seed) {
    const double side = std::sqrt(0.5 * poses * block / kVisits);
    side_ = block * std::max(1, static_cast<int>(std::lround(side / block)));
  }

  std::pair<int, int> place() const { return {x_, y_}; }
  bool at_crossing() const { return x_ % block_ == 0 && y_ % block_ == 0; }
  SE2 pose() const { return {double(x_), double(y_), heading_ * M_PI / 2}; }

  void advance() {
    if (at_crossing()) turn();
    x_ += kAhead[heading_].first;
    y_ += kAhead[heading_].second;
  }

 private:
  static constexpr std::array<std::pair<int, int>, 4> kAhead{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

  void turn() {
    const std::uint64_t draw = random_() % 4;  // two of four go straight on
    if (draw < 2) heading_ = (heading_ + (draw == 0 ? 1 : 3)) % 4;
    for (const auto inside = [&](int at) { return at >= 0 && at <= side_; };
         !inside(x_ + kAhead[heading_].first) || !inside(y_ + kAhead[heading_].second);) {
      heading_ = (heading_ + 1) % 4;
    }
  }

  int block_, side_ = 0, x_ = 0, y_ = 0, heading_ = 0;
  std::mt19937_64 random_;
};

/// Streets 5 m apart; each pose is measured from the one before, and from the newest earlier one at
/// its place.
inline World manhattan(int poses, std::uint64_t seed) {
  Drive drive(poses, 5, seed);
  std::vector<SE2> truth;
  std::vector<std::pair<int, int>> places;
  for (int i = 0; i < poses; ++i, drive.advance()) {
    truth.push_back(drive.pose());
    places.push_back(drive.place());
  }
  worlds::Measurer<SE2> measure(truth, static_cast<unsigned>(seed) + 1);
  std::map<std::pair<int, int>, int> newest;
  for (int i = 0; i < poses; ++i) {
    if (i > 0) measure.edge(i - 1, i, kRoad);
    const auto seen = newest.find(places[i]);
    if (seen != newest.end() && i - seen->second > kPosesBetween)
      measure.edge(seen->second, i, kRoad);
    newest[places[i]] = i;
  }
  return measure.take();
}

/// Streets 20 m apart with a landmark every 10 m beside them; each pose sees those within 8 m. At
/// crossings a pose is also measured from the newest earlier one there.
inline World city(int poses, std::uint64_t seed) {
  constexpr int kSpacing = 10, kReach = 8;
  Drive drive(poses, 20, seed);
  std::vector<SE2> truth;
  std::vector<std::pair<int, int>> places;
  std::vector<bool> crossing;
  for (int i = 0; i < poses; ++i, drive.advance()) {
    truth.push_back(drive.pose());
    places.push_back(drive.place());
    crossing.push_back(drive.at_crossing());
  }
  worlds::Measurer<SE2> measure(truth, static_cast<unsigned>(seed) + 1);
  std::map<std::pair<int, int>, int> newest;
  for (int i = 0; i < poses; ++i) {
    if (i > 0) measure.edge(i - 1, i, kRoad);
    if (!crossing[i]) continue;
    const auto seen = newest.find(places[i]);
    if (seen != newest.end() && i - seen->second > kPosesBetween)
      measure.edge(seen->second, i, kRoad);
    newest[places[i]] = i;
  }
  World world = measure.take();
  std::map<std::pair<int, int>, std::uint64_t> landmarks;
  std::mt19937_64 random(seed + 2);
  std::normal_distribution<double> normal(0.0, kSightSigma);
  const Noise noise = Noise::isotropic(2, kSightSigma);
  const auto cell = [](int at) { return static_cast<int>(std::lround(double(at) / kSpacing)); };
  for (int i = 0; i < poses; ++i) {
    const Key pose('x', static_cast<std::uint64_t>(i));
    for (int a = cell(places[i].first) - 1; a <= cell(places[i].first) + 1; ++a) {
      for (int b = cell(places[i].second) - 1; b <= cell(places[i].second) + 1; ++b) {
        // Three metres off the middle of the street.
        const Eigen::Vector2d point(a * kSpacing + 3.0, b * kSpacing + 3.0);
        const Eigen::Vector2d seen = truth[i].inverse() * point;
        if (seen.norm() > kReach) continue;
        const auto number = landmarks.emplace(std::pair(a, b), landmarks.size()).first->second;
        const Key landmark('l', number);
        if (!world.truth.contains(landmark)) world.truth.insert(landmark, point);
        const Eigen::Vector2d error(normal(random), normal(random));
        world.graph.points2.push_back({pose, landmark, seen + error, noise});
      }
    }
  }
  return world;
}

/// Rounds on a sphere, as many as poses in a round; each pose is measured from the one before, and
/// from that of the round before.
inline World sphere(int poses, std::uint64_t seed) {
  const int rounds = std::max(3, static_cast<int>(std::lround(std::sqrt(poses))));
  return worlds::sphere(rounds, rounds, kFlight, static_cast<unsigned>(seed));
}

inline World scale_world(const std::string& name, int poses, std::uint64_t seed) {
  if (name == "manhattan") return manhattan(poses, seed);
  if (name == "city") return city(poses, seed);
  if (name == "sphere") return sphere(poses, seed);
  throw std::invalid_argument("there is no world '" + name + "': manhattan, city or sphere");
}

}  // namespace hybrid::bench
