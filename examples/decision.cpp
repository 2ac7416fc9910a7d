// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A discrete decision of one's own: a robot drives a circle twice, and its sensor numbers posts
// anew in each round. Which posts of the second round are posts of the first? And one post was set
// up in between, 1.5 m beside an old one.
#include <Eigen/LU>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/smoother/proposal.h"

namespace {

using namespace hybrid;

constexpr double kDensity = 0.01;       // of posts [1/m^2]
const double kMargin = std::log(20.0);  // odds that a decision needs

struct Look {
  Key pose;
  Eigen::Vector2d z;  // range and bearing
  Handle factor;
};
using Posts = std::map<Key, std::vector<Look>>;

/// Two posts that may be one.
struct Pair {
  Key from, into;
  double evidence = 0;      // log odds that they are, against two posts
  double allowed_rise = 0;  // of the objective, by what the post less is worth
};

/// The generator: pairs of posts, nearest neighbours, by (E3) of docs/evidence.md. It changes
/// nothing.
std::vector<Pair> pairs_of(const Posts& posts, const IncrementalSmoother& map) {
  std::vector<Pair> out;
  for (auto b = posts.begin(); b != posts.end(); ++b) {
    for (auto a = posts.begin(); a != b; ++a) {
      const Eigen::Vector2d d =
          map.values().at<Eigen::Vector2d>(b->first) - map.values().at<Eigen::Vector2d>(a->first);
      if (d.norm() > 3) continue;  // a budget: only what is worth asking
      Eigen::MatrixXd J(2, 4);
      J << -Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity();
      const Eigen::Matrix2d S = J * map.joint_covariance({a->first, b->first}) * J.transpose();
      const double chi_square = d.dot(S.inverse() * d);
      const double evidence =
          -0.5 * chi_square - 0.5 * std::log((2 * M_PI * S).determinant()) - std::log(kDensity);
      if (evidence > kMargin)
        out.push_back({b->first, a->first, evidence, evidence + 0.5 * chi_square});
    }
  }
  return out;
}

/// The change: what was seen of one post was seen of the other.
Proposal proposal_of(const Pair& pair, const Posts& posts, const Noise& noise) {
  Proposal proposal;
  proposal.allowed_rise = pair.allowed_rise;
  for (const Look& look : posts.at(pair.from)) {
    proposal.delta.remove.push_back(look.factor);
    proposal.delta.continuous.push_back(
        std::make_shared<BearingRange2>(look.pose, pair.into, look.z, noise, SE2()));
  }
  proposal.delta.remove_values.push_back(pair.from);
  return proposal;
}

/// Tried on the map itself, settled, compared; then kept, or the map is as it was to the last bit.
/// The books change only once it is kept.
bool is_kept(const Pair& pair, const Noise& noise, Posts& posts, IncrementalSmoother& map) {
  const UpdateReport report = propose(map, proposal_of(pair, posts, noise));
  if (report.status != UpdateReport::Status::kOk) return false;
  std::vector<Look> moved = posts.at(pair.from);
  for (std::size_t i = 0; i < moved.size(); ++i) {
    moved[i].factor = report.handles.continuous[i];
    posts.at(pair.into).push_back(moved[i]);
  }
  posts.erase(pair.from);
  return true;
}

}  // namespace

int main() {
  std::mt19937 random(5);
  const auto noisy = [&](double sigma) {
    return sigma * std::normal_distribution<double>()(random);
  };
  const auto truth = [](int i) {
    return SE2(10 * std::cos(0.1 * i), 10 * std::sin(0.1 * i), 0.1 * i + M_PI / 2);
  };
  const Noise walk = Noise::diagonal(Eigen::Vector3d(0.03, 0.03, 0.006));
  const Noise sight = Noise::diagonal(Eigen::Vector2d(0.1, 0.01));
  constexpr int kRound = 63, kPosts = 8;
  IncrementalSmoother map;
  Posts posts;
  for (int i = 0; i < 2 * kRound; ++i) {
    Delta delta;
    const Key pose('x', i);
    const SE2 motion =
        i == 0 ? truth(0)
               : truth(i - 1).between(truth(i)) * SE2(noisy(0.03), noisy(0.03), noisy(0.006));
    if (i == 0) {
      delta.continuous.push_back(std::make_shared<Prior<SE2>>(pose, motion, walk));
    } else {
      delta.continuous.push_back(std::make_shared<BetweenSE2>(Key('x', i - 1), pose, motion, walk));
    }
    const SE2 here = i == 0 ? motion : map.values().at<SE2>(Key('x', i - 1)) * motion;
    delta.values.insert(pose, here);
    const int round = i / kRound;
    std::vector<std::pair<Key, Look>> seen;
    for (int k = 0; k < kPosts + round; ++k) {  // the last one is new in the second round
      const double angle = 2 * M_PI * k / kPosts, radius = k < kPosts ? 13 : 14.5;
      const Eigen::Vector2d post(radius * std::cos(angle), radius * std::sin(angle));
      Eigen::Vector2d z = to_polar(Eigen::Vector2d(truth(i).inverse() * post));
      if (z[0] > 8) continue;
      z += Eigen::Vector2d(noisy(0.1), noisy(0.01));
      const Key name('p', 100 * round + k);
      if (posts.count(name) == 0) delta.values.insert(name, Eigen::Vector2d(here * from_polar(z)));
      delta.continuous.push_back(std::make_shared<BearingRange2>(pose, name, z, sight, SE2()));
      seen.push_back({name, {pose, z, {}}});
      posts[name];
    }
    const UpdateReport report = map.update(delta);
    if (report.status != UpdateReport::Status::kOk) return 1;
    for (std::size_t s = 0; s < seen.size(); ++s) {
      seen[s].second.factor = report.handles.continuous[s + 1];  // behind that of the motion
      posts[seen[s].first].push_back(seen[s].second);
    }
  }
  std::cout << posts.size() << " posts before\n";
  for (bool again = true; again;) {  // what is kept moves the map, so that each is asked anew
    again = false;
    for (const Pair& pair : pairs_of(posts, map)) {
      again = is_kept(pair, sight, posts, map);
      std::cout << pair.from.index() << " is " << pair.into.index() << ": evidence "
                << pair.evidence << (again ? ", kept\n" : ", turned down\n");
      if (again) break;
    }
  }
  std::cout << posts.size() << " posts after\n";
  return posts.size() == kPosts + 1 ? 0 : 1;
}
