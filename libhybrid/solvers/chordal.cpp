// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/chordal.h"

#include <Eigen/SVD>
#include <cmath>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr double kAnchorSigma = 1e-6;

/// b = M a + c.
template <int N>
class LinearRelation
    : public FactorOf<N, Eigen::Matrix<double, N, 1>, Eigen::Matrix<double, N, 1>> {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  using Base = FactorOf<N, Vector, Vector>;

  LinearRelation(Key a, Key b, const Matrix& M, const Vector& c, double sigma)
      : Base({a, b}, Noise::isotropic(N, sigma)), M_(M), c_(c) {}

  std::string name() const override { return "linear relation"; }
  typename Base::Residual evaluate(const Vector& a, const Vector& b, Matrix* Ja,
                                   Matrix* Jb) const override {
    if (Ja != nullptr) {
      *Ja = -M_;
      Jb->setIdentity();
    }
    return b - M_ * a - c_;
  }

 private:
  Matrix M_;
  Vector c_;
};

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

template <int N>
using Vectors = std::unordered_map<Key, Eigen::Matrix<double, N, 1>>;

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
  SolverOptions options;
  options.max_iterations = 3;  // one is exact but for rounding
  const SolverResult solved = levenberg_marquardt(graph, {values, {}}, options);
  Vectors<N> result;
  for (Key key : keys) {
    result[key] = solved.values.template at<Eigen::Matrix<double, N, 1>>(key);
  }
  return result;
}

using Rotations2 = std::unordered_map<Key, SO2>;
using Rotations3 = std::unordered_map<Key, SO3>;

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
  for (const auto& [key, matrix] : matrices) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d U = svd.matrixU();
    if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) *= -1.0;
    result[key] = SO3(Eigen::Quaterniond(Eigen::Matrix3d(U * svd.matrixV().transpose())));
  }
  return result;
}

/// Relations that are connected to an anchor, directly or through others, and their poses in order
/// of appearance.
template <class Pose>
std::vector<Relation<Pose>> connected(const std::vector<Relation<Pose>>& relations,
                                      const std::vector<Key>& anchors, std::vector<Key>& keys) {
  std::unordered_map<Key, std::vector<std::size_t>> incident;
  for (std::size_t r = 0; r < relations.size(); ++r) {
    incident[relations[r].from].push_back(r);
    incident[relations[r].to].push_back(r);
  }
  std::unordered_set<Key> reached(anchors.begin(), anchors.end());
  keys = anchors;
  std::vector<bool> used(relations.size(), false);
  std::vector<Relation<Pose>> result;
  for (std::size_t next = 0; next < keys.size(); ++next) {
    const Key key = keys[next];
    for (std::size_t r : incident[key]) {
      if (used[r]) continue;
      used[r] = true;
      result.push_back(relations[r]);
      for (Key end : {relations[r].from, relations[r].to}) {
        if (reached.insert(end).second) keys.push_back(end);
      }
    }
  }
  return result;
}

template <class Pose>
void initialize(const std::vector<Relation<Pose>>& all, const std::vector<Key>& priors,
                Values& values) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  if (all.empty()) return;
  std::vector<Key> anchors;
  for (Key key : priors) {
    if (values.type(key) == Variable<Pose>::type()) anchors.push_back(key);
  }
  if (anchors.empty()) anchors.push_back(all.front().from);
  std::vector<Key> keys;
  const std::vector<Relation<Pose>> relations = connected(all, anchors, keys);
  const auto rotations = solve_rotations(relations, keys, anchors, values);
  HybridGraph graph;
  for (const auto& relation : relations) {
    graph.emplace<LinearRelation<kPosition>>(
        relation.from, relation.to, Eigen::Matrix<double, kPosition, kPosition>::Identity(),
        (rotations.at(relation.from) * relation.measured.translation()).eval(),
        relation.translation_sigma);
  }
  Vectors<kPosition> fixed;
  for (Key key : anchors) fixed[key] = values.at<Pose>(key).translation();
  const Vectors<kPosition> positions = solve_linear<kPosition>(graph, fixed, keys);
  for (Key key : keys) {
    if (fixed.count(key) == 0) values.update(key, Pose(positions.at(key), rotations.at(key)));
  }
}

}  // namespace

Values chordal_initialization(const std::vector<ContinuousFactorPtr>& factors,
                              const Values& initial) {
  std::vector<Relation<SE2>> planar;
  std::vector<Relation<SE3>> spatial;
  std::vector<Key> priors;
  for (const ContinuousFactorPtr& factor : factors) {
    const bool relative = add_relation(*factor, planar) || add_relation(*factor, spatial);
    if (!relative && factor->keys().size() == 1) priors.push_back(factor->keys()[0]);
  }
  Values values = initial;
  initialize(planar, priors, values);
  initialize(spatial, priors, values);
  return values;
}

}  // namespace hybrid
