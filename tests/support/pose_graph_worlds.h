// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid::worlds {

/// A pose graph made from a known trajectory. `graph.values` is empty: tests set it as a file
/// might.
struct World {
  PoseGraph graph;
  Values truth;
};

/// Standard deviations of a relative pose.
struct Sigmas {
  double translation = 0.1;  // [m]
  double rotation = 0.1;     // [rad]
};

inline void add_edge(PoseGraph& graph, Key a, Key b, const SE2& z, const Noise& noise) {
  graph.poses2.push_back({a, b, z, noise});
}
inline void add_edge(PoseGraph& graph, Key a, Key b, const SE3& z, const Noise& noise) {
  graph.poses3.push_back({a, b, z, noise});
}

/// Measures relative poses of a trajectory.
template <class Pose>
class Measurer {
 public:
  Measurer(const std::vector<Pose>& truth, unsigned seed) : random_(seed) {
    for (std::size_t i = 0; i < truth.size(); ++i) world_.truth.insert(Key('x', i), truth[i]);
  }

  /// z = a^-1 b Exp(e), with e drawn from the stated noise.
  void edge(std::size_t a, std::size_t b, const Sigmas& sigmas) {
    constexpr int kPoint = Pose::Point::RowsAtCompileTime;
    Eigen::VectorXd sigma(Pose::kDim);
    for (int k = 0; k < Pose::kDim; ++k)
      sigma[k] = k < kPoint ? sigmas.translation : sigmas.rotation;
    typename Pose::Tangent e;
    for (int k = 0; k < Pose::kDim; ++k)
      e[k] = sigma[k] * std::normal_distribution<double>()(random_);
    const Key from('x', a), to('x', b);
    const Pose z = world_.truth.at<Pose>(from).between(world_.truth.at<Pose>(to)) * Pose::exp(e);
    add_edge(world_.graph, from, to, z, Noise::diagonal(sigma));
  }

  double uniform() { return std::uniform_real_distribution<double>()(random_); }
  World take() { return std::move(world_); }

 private:
  World world_;
  std::mt19937_64 random_;
};

/// A pose at p with its x axis along `ahead`, and its z axis as near to `up` as possible.
inline SE3 looking(const Eigen::Vector3d& p, const Eigen::Vector3d& ahead,
                   const Eigen::Vector3d& up) {
  const Eigen::Vector3d x = ahead.normalized();
  const Eigen::Vector3d y = up.cross(x).normalized();
  Eigen::Matrix3d R;
  R << x, y, x.cross(y);
  return {p, Eigen::Quaterniond(R)};
}

/// Odometry along the trajectory, and closures to the pose `stride` poses back.
inline World wound(const std::vector<SE3>& truth, std::size_t stride, const Sigmas& sigmas,
                   unsigned seed) {
  Measurer<SE3> measure(truth, seed);
  for (std::size_t i = 1; i < truth.size(); ++i) {
    measure.edge(i - 1, i, sigmas);
    if (i >= stride) measure.edge(i - stride, i, sigmas);
  }
  return measure.take();
}

/// Rounds on a sphere from pole to pole, each with closures to the previous one.
inline World sphere(int rounds, int per_round, const Sigmas& sigmas, unsigned seed) {
  std::vector<SE3> truth;
  for (int i = 0; i < rounds * per_round; ++i) {
    const double a = 2 * M_PI * i / per_round;
    const double b = M_PI * ((i + 0.5) / (rounds * per_round) - 0.5);
    const Eigen::Vector3d up(std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b));
    truth.push_back(looking(10 * up, {-std::sin(a), std::cos(a), 0.0}, up));
  }
  return wound(truth, per_round, sigmas, seed);
}

/// Rounds on the tube of a torus.
inline World torus(int rounds, int per_round, const Sigmas& sigmas, unsigned seed) {
  std::vector<SE3> truth;
  for (int i = 0; i < rounds * per_round; ++i) {
    const double a = 2 * M_PI * i / (rounds * per_round);
    const double b = 2 * M_PI * i / per_round;
    const Eigen::Vector3d out(std::cos(a), std::sin(a), 0.0);
    const Eigen::Vector3d up = std::cos(b) * out + std::sin(b) * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d ahead = -std::sin(b) * out + std::cos(b) * Eigen::Vector3d::UnitZ();
    truth.push_back(looking(10 * out + 3 * up, ahead, up));
  }
  return wound(truth, per_round, sigmas, seed);
}

/// A lattice of n x n x n places, traversed to and fro, with a share of its other edges as
/// closures.
inline World grid3(int n, double share, const Sigmas& sigmas, unsigned seed) {
  std::vector<SE3> truth;
  std::vector<Eigen::Vector3i> places;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const int y = k % 2 == 0 ? j : n - 1 - j;
        const int x = (k * n + j) % 2 == 0 ? i : n - 1 - i;
        places.emplace_back(x, y, k);
      }
    }
  }
  std::mt19937_64 random(seed + 1);
  std::normal_distribution<double> normal;
  for (const Eigen::Vector3i& place : places) {
    truth.emplace_back(
        place.cast<double>(),
        SO3::exp(3.0 * Eigen::Vector3d(normal(random), normal(random), normal(random))));
  }
  Measurer<SE3> measure(truth, seed);
  for (std::size_t i = 1; i < truth.size(); ++i) measure.edge(i - 1, i, sigmas);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t j = i + 2; j < truth.size(); ++j) {
      if ((places[i] - places[j]).cwiseAbs().sum() == 1 && measure.uniform() < share) {
        measure.edge(i, j, sigmas);
      }
    }
  }
  return measure.take();
}

/// Random driving through the streets of a town, with a share of the closures between poses at the
/// same place.
inline World town(int poses, int size, double share, const Sigmas& sigmas, unsigned seed) {
  std::mt19937_64 random(seed + 1);
  std::vector<SE2> truth{SE2()};
  while (static_cast<int>(truth.size()) < poses) {
    const double turn = std::uniform_int_distribution<int>(0, 4)(random) - 2.0;
    const SE2 next =
        truth.back() * SE2(0, 0, std::abs(turn) == 1 ? turn * M_PI / 2 : 0) * SE2(1, 0, 0);
    if (std::abs(next.x()) <= size && std::abs(next.y()) <= size) {
      truth.push_back(next);
    } else {
      truth.back() = truth.back() * SE2(0, 0, M_PI / 2);
    }
  }
  Measurer<SE2> measure(truth, seed);
  for (std::size_t i = 1; i < truth.size(); ++i) measure.edge(i - 1, i, sigmas);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (std::size_t j = i + 2; j < truth.size(); ++j) {
      const bool near = (truth[i].translation() - truth[j].translation()).norm() < 0.5;
      if (near && measure.uniform() < share) measure.edge(i, j, sigmas);
    }
  }
  return measure.take();
}

/// A building: rounds of a corridor with very bad odometry, and few good closures between rounds.
inline World building(int rounds, int side, const Sigmas& odometry, const Sigmas& closure,
                      unsigned seed) {
  std::vector<SE2> truth{SE2()};
  for (int i = 1; i < rounds * 4 * side; ++i) {
    truth.push_back(truth.back() * SE2(1, 0, i % side == 0 ? M_PI / 2 : 0));
  }
  Measurer<SE2> measure(truth, seed);
  for (std::size_t i = 1; i < truth.size(); ++i) measure.edge(i - 1, i, odometry);
  const std::size_t round = 4 * static_cast<std::size_t>(side);
  for (std::size_t i = 0; i + round < truth.size(); i += static_cast<std::size_t>(side) / 2) {
    measure.edge(i, i + round, closure);
  }
  return measure.take();
}

/// Sets initial poses unrelated to the graph: the true ones in a random order.
inline void scramble(World& world, unsigned seed) {
  std::vector<Key> keys = world.truth.keys();
  std::vector<Key> others = keys;
  std::shuffle(others.begin(), others.end(), std::mt19937_64(seed));
  world.graph.values = {};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    world.graph.values.insert(keys[i], world.truth.type(keys[i]), world.truth.data(others[i]));
  }
}

/// The k-th of many small worlds of four kinds, with `more` rotation noise than little [rad].
inline World small_world(unsigned k, double more) {
  switch (k % 4) {
    case 0:
      return sphere(4, 8, {0.1, 0.05 + more}, k);
    case 1:
      return torus(5, 8, {0.1, 0.05 + more}, k);
    case 2:
      return grid3(3, 0.7, {0.1, 0.05 + more}, k);
    default:
      return town(60, 3, 0.4, {0.05, 0.02 + 0.4 * more}, k);
  }
}

}  // namespace hybrid::worlds
