// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/chordal.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/pose_graph/sighting_edges.h"
#include "libhybrid/solvers/detail/linear_relation.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr double kAnchorSigma = 1e-6;

template <class Pose>
struct Relation {
  Key from, to;
  Pose measured;
  double translation_sigma = 1.0;
  double rotation_sigma = 1.0;
};

template <class Pose>
bool add_relation(const ContinuousFactor& factor, std::vector<Relation<Pose>>& relations) {
  const std::optional<RelativePose<Pose>> motion = relative_pose<Pose>(factor);
  if (!motion) return false;
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  constexpr int kRotation = Pose::kDim - kPosition;
  const auto& information = motion->information;
  const double t = information.template topLeftCorner<kPosition, kPosition>().trace();
  const double r = information.template bottomRightCorner<kRotation, kRotation>().trace();
  relations.push_back({factor.keys()[0], factor.keys()[1], motion->measured,
                       std::sqrt(kPosition / t), std::sqrt(kRotation / r)});
  return true;
}

/// A point seen from a pose, with one standard deviation for all directions.
template <class Pose>
struct Sighting {
  Key from, to;
  typename Pose::Point measured;
  double sigma = 1.0;
};

template <class Pose>
bool add_point(const ContinuousFactor& factor, std::vector<Sighting<Pose>>& sightings) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  std::vector<GraphEdge<typename Pose::Point>> edges;
  if (!add_sighting<Pose>(factor, edges)) return false;
  for (const auto& edge : edges) {
    const double information = edge.noise.sqrt_information().squaredNorm();
    sightings.push_back({edge.from, edge.to, edge.measured, std::sqrt(kPosition / information)});
  }
  return true;
}

template <int N>
using Vectors = std::unordered_map<Key, Eigen::Matrix<double, N, 1>>;

SolverOptions linear_options() {
  SolverOptions options;
  options.max_iterations = 3;  // one is exact but for rounding
  return options;
}

/// Solves linear relations between vectors for the vectors that are not fixed.
template <int N>
Vectors<N> solve_linear(const HybridGraph& relations, const Vectors<N>& fixed,
                        const std::vector<Key>& keys) {
  HybridGraph graph = relations;
  Values values;
  for (Key key : keys) {
    const auto it = fixed.find(key);
    const Eigen::Matrix<double, N, 1> start =
        it == fixed.end() ? Eigen::Matrix<double, N, 1>::Zero().eval() : it->second;
    values.insert(key, start);
    if (it != fixed.end()) {
      graph.emplace<Prior<Eigen::Matrix<double, N, 1>>>(key, start,
                                                        Noise::isotropic(N, kAnchorSigma));
    }
  }
  const SolverResult solved = levenberg_marquardt(graph, {values, {}}, linear_options());
  Vectors<N> result;
  for (Key key : keys) {
    result[key] = solved.values.template at<Eigen::Matrix<double, N, 1>>(key);
  }
  return result;
}

using Rotations2 = std::unordered_map<Key, SO2>;
using Rotations3 = std::unordered_map<Key, SO3>;

SO2 nearest_rotation(const Eigen::Matrix2d& M) {
  return SO2(std::atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1)));
}

SO3 nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
  return SO3(Eigen::Quaterniond(Eigen::Matrix3d(U * svd.matrixV().transpose())));
}

/// The rotation of b, as (c, s), is that of a turned by the measured angle.
Rotations2 solve_rotations(const std::vector<Relation<SE2>>& relations,
                           const std::vector<Key>& keys, const std::vector<Key>& anchors,
                           const Values& initial) {
  HybridGraph graph;
  for (const auto& relation : relations) {
    const double c = relation.measured.rotation().cos();
    const double s = relation.measured.rotation().sin();
    graph.emplace<LinearRelation<2>>(relation.from, relation.to,
                                     (Eigen::Matrix2d() << c, -s, s, c).finished(),
                                     Eigen::Vector2d::Zero(), relation.rotation_sigma);
  }
  Vectors<2> fixed;
  for (Key key : anchors) {
    const SO2 rotation = initial.at<SE2>(key).rotation();
    fixed[key] = Eigen::Vector2d(rotation.cos(), rotation.sin());
  }
  Rotations2 result;
  for (const auto& [key, v] : solve_linear<2>(graph, fixed, keys)) {
    const double norm = v.norm();
    result[key] = norm > 0.0 ? SO2::from_cos_sin(v.x() / norm, v.y() / norm) : SO2();
  }
  return result;
}

/// Each row of the rotation matrix of b is that of a times the measured rotation: three systems of
/// the same structure.
Rotations3 solve_rotations(const std::vector<Relation<SE3>>& relations,
                           const std::vector<Key>& keys, const std::vector<Key>& anchors,
                           const Values& initial) {
  HybridGraph graph;
  for (const auto& relation : relations) {
    graph.emplace<LinearRelation<3>>(relation.from, relation.to,
                                     relation.measured.rotation().matrix().transpose().eval(),
                                     Eigen::Vector3d::Zero(), relation.rotation_sigma);
  }
  std::unordered_map<Key, Eigen::Matrix3d> matrices;
  for (int row = 0; row < 3; ++row) {
    Vectors<3> fixed;
    for (Key key : anchors) {
      fixed[key] = initial.at<SE3>(key).rotation().matrix().row(row).transpose();
    }
    for (const auto& [key, v] : solve_linear<3>(graph, fixed, keys)) {
      matrices[key].row(row) = v.transpose();
    }
  }
  Rotations3 result;
  for (const auto& [key, matrix] : matrices) result[key] = nearest_rotation(matrix);
  return result;
}

/// The indices of the links that are connected to an anchor, directly or through others, and their
/// variables, both in order of appearance.
std::vector<std::size_t> connected(const std::vector<std::pair<Key, Key>>& links,
                                   const std::vector<Key>& anchors, std::vector<Key>& keys) {
  std::unordered_map<Key, std::vector<std::size_t>> incident;
  for (std::size_t l = 0; l < links.size(); ++l) {
    incident[links[l].first].push_back(l);
    incident[links[l].second].push_back(l);
  }
  std::unordered_set<Key> reached;
  keys.clear();
  for (const Key anchor : anchors) {
    if (reached.insert(anchor).second) keys.push_back(anchor);  // several priors may hold one
  }
  std::vector<bool> used(links.size(), false);
  std::vector<std::size_t> result;
  for (std::size_t next = 0; next < keys.size(); ++next) {
    const Key key = keys[next];
    for (std::size_t l : incident[key]) {
      if (used[l]) continue;
      used[l] = true;
      result.push_back(l);
      for (Key end : {links[l].first, links[l].second}) {
        if (reached.insert(end).second) keys.push_back(end);
      }
    }
  }
  return result;
}

/// What measures poses and points, connected to the variables that stay where they are.
template <class Pose>
struct Measurements {
  std::vector<Relation<Pose>> relations;
  std::vector<Sighting<Pose>> sightings;
  std::vector<Key> anchors;  // poses and points
  std::vector<Key> keys;

  /// Leaves out what is not connected to an anchor.
  void connect() {
    std::vector<std::pair<Key, Key>> links;
    for (const auto& relation : relations) links.emplace_back(relation.from, relation.to);
    for (const auto& sighting : sightings) links.emplace_back(sighting.from, sighting.to);
    std::vector<Relation<Pose>> reached;
    std::vector<Sighting<Pose>> seen;
    for (const std::size_t l : connected(links, anchors, keys)) {
      if (l < relations.size()) {
        reached.push_back(relations[l]);
      } else {
        seen.push_back(sightings[l - relations.size()]);
      }
    }
    relations = std::move(reached);
    sightings = std::move(seen);
  }
};

template <class Pose>
bool is_pose(Key key, const Values& values) {
  return values.type(key) == Variable<Pose>::type();
}

/// The rotations of poses that see points. Each row of [R t] of a pose and the same coordinate of
/// the points are one linear problem: y_j = T_ij' y_i, p = (z, 1)' y_i. Without the constraints of
/// rotations, which the result is projected on.
template <class Pose>
auto rotations_with_points(const Measurements<Pose>& measured, const Values& initial) {
  constexpr int N = Pose::Point::RowsAtCompileTime;
  using Row = Eigen::Matrix<double, N + 1, 1>;
  using Square = Eigen::Matrix<double, N + 1, N + 1>;
  HybridGraph graph;
  for (const auto& relation : measured.relations) {
    Square T = Square::Identity();
    T.template topLeftCorner<N, N>() = relation.measured.rotation().matrix();
    T.template topRightCorner<N, 1>() = relation.measured.translation();
    Row sigmas = Row::Constant(std::sqrt(2.0) * relation.rotation_sigma);  // |dR|^2 is 2 angle^2
    sigmas[N] = relation.translation_sigma;
    graph.emplace<LinearRelation<N + 1>>(relation.from, relation.to, T.transpose().eval(),
                                         Row::Zero().eval(), Noise::diagonal(sigmas));
  }
  for (const auto& sighting : measured.sightings) {
    graph.emplace<LinearForm<N + 1>>(sighting.from, sighting.to, sighting.measured.homogeneous(),
                                     sighting.sigma);
  }
  std::unordered_map<Key, Eigen::Matrix<double, N, N>> matrices;
  for (int row = 0; row < N; ++row) {
    HybridGraph anchored = graph;
    Values values;
    for (Key key : measured.keys) {
      if (is_pose<Pose>(key, initial)) {
        values.insert(key, Row::Zero().eval());
      } else {
        values.insert(key, Scalar::Zero().eval());
      }
    }
    for (Key key : measured.anchors) {
      if (is_pose<Pose>(key, initial)) {
        const Pose pose = initial.at<Pose>(key);
        Row y;
        y << pose.rotation().matrix().row(row).transpose(), pose.translation()[row];
        anchored.emplace<Prior<Row>>(key, y, Noise::isotropic(N + 1, kAnchorSigma));
      } else {
        const Scalar p(initial.at<typename Pose::Point>(key)[row]);
        anchored.emplace<Prior<Scalar>>(key, p, Noise::isotropic(1, kAnchorSigma));
      }
    }
    const SolverResult solved = levenberg_marquardt(anchored, {values, {}}, linear_options());
    for (Key key : measured.keys) {
      if (!is_pose<Pose>(key, initial)) continue;
      matrices[key].row(row) = solved.values.template at<Row>(key).template head<N>().transpose();
    }
  }
  std::unordered_map<Key, decltype(nearest_rotation(Eigen::Matrix<double, N, N>()))> result;
  for (const auto& [key, matrix] : matrices) result[key] = nearest_rotation(matrix);
  return result;
}

template <class Pose>
void initialize(Measurements<Pose> measured, Values& values) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  using Point = typename Pose::Point;
  using Matrix = Eigen::Matrix<double, kPosition, kPosition>;
  if (measured.relations.empty()) return;
  std::unordered_set<Key> seen;
  for (const auto& sighting : measured.sightings) seen.insert(sighting.to);
  const auto is_here = [&](Key key) { return is_pose<Pose>(key, values) || seen.count(key) != 0; };
  std::vector<Key>& anchors = measured.anchors;
  anchors.erase(std::remove_if(anchors.begin(), anchors.end(), [&](Key k) { return !is_here(k); }),
                anchors.end());
  if (std::none_of(anchors.begin(), anchors.end(),
                   [&](Key key) { return is_pose<Pose>(key, values); })) {
    anchors.push_back(measured.relations.front().from);
  }
  measured.connect();
  const auto rotations = measured.sightings.empty()
                             ? solve_rotations(measured.relations, measured.keys, anchors, values)
                             : rotations_with_points(measured, values);
  HybridGraph graph;
  for (const auto& relation : measured.relations) {
    graph.emplace<LinearRelation<kPosition>>(
        relation.from, relation.to, Matrix::Identity(),
        (rotations.at(relation.from) * relation.measured.translation()).eval(),
        relation.translation_sigma);
  }
  for (const auto& sighting : measured.sightings) {
    graph.emplace<LinearRelation<kPosition>>(
        sighting.from, sighting.to, Matrix::Identity(),
        (rotations.at(sighting.from) * sighting.measured).eval(), sighting.sigma);
  }
  Vectors<kPosition> fixed;
  for (Key key : anchors) {
    fixed[key] =
        is_pose<Pose>(key, values) ? values.at<Pose>(key).translation() : values.at<Point>(key);
  }
  const Vectors<kPosition> positions = solve_linear<kPosition>(graph, fixed, measured.keys);
  for (Key key : measured.keys) {
    if (fixed.count(key) != 0) continue;
    if (is_pose<Pose>(key, values)) {
      values.update(key, Pose(positions.at(key), rotations.at(key)));
    } else {
      values.update(key, positions.at(key));
    }
  }
}

}  // namespace

Values chordal_initialization(const std::vector<ContinuousFactorPtr>& factors,
                              const Values& initial) {
  Measurements<SE2> planar;
  Measurements<SE3> spatial;
  for (const ContinuousFactorPtr& factor : factors) {
    const bool known =
        add_relation(*factor, planar.relations) || add_relation(*factor, spatial.relations) ||
        add_point(*factor, planar.sightings) || add_point(*factor, spatial.sightings);
    if (known || factor->keys().size() != 1) continue;
    planar.anchors.push_back(factor->keys()[0]);
    spatial.anchors.push_back(factor->keys()[0]);
  }
  Values values = initial;
  initialize(std::move(planar), values);
  initialize(std::move(spatial), values);
  return values;
}

}  // namespace hybrid
