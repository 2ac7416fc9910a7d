// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/detail/isotropic_graph.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "libhybrid/factors/relative_pose.h"

namespace hybrid {
namespace {

constexpr double kNegligible = 1e-6;  // relative difference of information

template <class Pose>
using OtherPose = std::conditional_t<std::is_same_v<Pose, SE2>, SE3, SE2>;

/// Weight b b' for a sparse vector b.
void add_square(double weight, const std::vector<std::pair<int, double>>& b,
                std::vector<Eigen::Triplet<double>>& triplets) {
  for (const auto& [r, x] : b) {
    for (const auto& [c, y] : b) triplets.emplace_back(r, c, weight * x * y);
  }
}

SE2 pose_of(const Eigen::Matrix2d& R, const Eigen::Vector2d& t) {
  return {t.x(), t.y(), std::atan2(R(1, 0), R(0, 0))};
}
SE3 pose_of(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  return {t, Eigen::Quaterniond(R)};
}

template <class Pose>
int pose_count(const std::vector<IsotropicEdge<Pose>>& graph) {
  int last = 0;
  for (const auto& edge : graph) last = std::max({last, edge.i, edge.j});
  return last + 1;
}

/// Whether a large error costs less than by the information, as under a robust loss.
template <class Pose>
bool is_robust(const ContinuousFactor& factor, const RelativePose<Pose>& motion) {
  constexpr double kSigmas = 1e3;
  typename Pose::Tangent error = Pose::Tangent::Zero();
  error[0] = kSigmas / std::sqrt(motion.information(0, 0));
  Values values;
  values.insert(factor.keys()[0], Pose());
  values.insert(factor.keys()[1], motion.measured * Pose::exp(error));
  return factor.cost(values) < 0.5 * kSigmas * kSigmas * (1.0 - kNegligible);
}

template <class Pose>
void set_weights(const typename Pose::Jacobian& information, IsotropicWeights weights,
                 IsotropicEdge<Pose>& edge) {
  constexpr int d = Pose::Point::RowsAtCompileTime;
  constexpr int kRotation = Pose::kDim - d;
  const typename Pose::Jacobian covariance = information.inverse();
  const double tau = d / covariance.template topLeftCorner<d, d>().trace();
  const double turn =
      kRotation / covariance.template bottomRightCorner<kRotation, kRotation>().trace();
  typename Pose::Tangent root;
  root.template head<d>().setConstant(1.0 / std::sqrt(tau));
  root.template tail<kRotation>().setConstant(1.0 / std::sqrt(turn));
  const typename Pose::Jacobian relative = root.asDiagonal() * information * root.asDiagonal();
  const double least =
      Eigen::SelfAdjointEigenSolver<typename Pose::Jacobian>(relative).eigenvalues()[0];
  const double share = weights == IsotropicWeights::kLower ? least : 1.0;
  edge.is_bound = share <= least * (1.0 + kNegligible);
  edge.tau = share * tau;
  edge.kappa = 0.5 * share * turn;
}

}  // namespace

template <class Pose>
std::vector<IsotropicEdge<Pose>> relative_poses(const std::vector<ContinuousFactorPtr>& factors,
                                                IsotropicWeights weights) {
  std::vector<IsotropicEdge<Pose>> graph;
  std::unordered_map<Key, int> numbers;
  const auto number = [&](Key key) {
    return numbers.emplace(key, static_cast<int>(numbers.size())).first->second;
  };
  for (const ContinuousFactorPtr& factor : factors) {
    const auto motion = relative_pose<Pose>(*factor);
    if (!motion && factor->keys().size() > 1 && !relative_pose<OtherPose<Pose>>(*factor)) {
      throw Error(describe(factor->name(), factor->keys()) +
                  ": only graphs of relative poses can be certified");
    }
    if (!motion) continue;
    const bool robust = is_robust(*factor, *motion);
    if (robust && weights == IsotropicWeights::kLower) continue;
    const Key from = factor->keys()[0], to = factor->keys()[1];
    const int i = number(from), j = number(to);
    graph.push_back({from, to, i, j, motion->measured});
    set_weights(motion->information, weights, graph.back());
    graph.back().is_bound = graph.back().is_bound && !robust;
  }
  return graph;
}

template <class Pose>
IsotropicForm isotropic_form(const std::vector<IsotropicEdge<Pose>>& graph) {
  IsotropicForm form;
  form.d = Pose::Point::RowsAtCompileTime;
  form.poses = pose_count(graph);
  std::vector<Eigen::Triplet<double>> triplets;
  for (const IsotropicEdge<Pose>& edge : graph) {
    const auto R = edge.measured.rotation().matrix();
    const typename Pose::Point t = edge.measured.translation();
    std::vector<std::pair<int, double>> a;
    if (edge.j > 0) a.emplace_back(edge.j - 1, 1.0);
    if (edge.i > 0) a.emplace_back(edge.i - 1, -1.0);
    for (int k = 0; k < form.d; ++k) a.emplace_back(form.rotation(edge.i) + k, -t[k]);
    add_square(edge.tau, a, triplets);
    for (int column = 0; column < form.d; ++column) {
      std::vector<std::pair<int, double>> b{{form.rotation(edge.j) + column, 1.0}};
      for (int k = 0; k < form.d; ++k) b.emplace_back(form.rotation(edge.i) + k, -R(k, column));
      add_square(edge.kappa, b, triplets);
    }
  }
  form.M.resize(form.size(), form.size());
  form.M.setFromTriplets(triplets.begin(), triplets.end());
  return form;
}

template <class Pose>
Eigen::MatrixXd stacked(const std::vector<IsotropicEdge<Pose>>& graph, const Values& poses) {
  constexpr int d = Pose::Point::RowsAtCompileTime;
  const int count = pose_count(graph);
  const typename Pose::Point origin = poses.at<Pose>(graph.front().from).translation();
  Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(count - 1 + d * count, d);
  for (const IsotropicEdge<Pose>& edge : graph) {
    for (const auto& [key, i] : {std::pair(edge.from, edge.i), std::pair(edge.to, edge.j)}) {
      const Pose pose = poses.at<Pose>(key);
      if (i > 0) Y.row(i - 1) = (pose.translation() - origin).transpose();
      Y.middleRows(count - 1 + d * i, d) = pose.rotation().matrix().transpose();
    }
  }
  return Y;
}

template <class Pose>
Values unstacked(const std::vector<IsotropicEdge<Pose>>& graph, const Eigen::MatrixXd& Y,
                 Key reference, Values values) {
  constexpr int d = Pose::Point::RowsAtCompileTime;
  using Rotation = Eigen::Matrix<double, d, d>;
  const int count = pose_count(graph);
  const auto pose = [&](int i) {
    const Rotation R = Y.middleRows(count - 1 + d * i, d).transpose();
    const typename Pose::Point t =
        i > 0 ? typename Pose::Point(Y.row(i - 1).transpose()) : Pose::Point::Zero().eval();
    return pose_of(R, t);
  };
  Pose move;
  for (const IsotropicEdge<Pose>& edge : graph) {
    if (edge.from == reference) move = values.at<Pose>(reference) * pose(edge.i).inverse();
    if (edge.to == reference) move = values.at<Pose>(reference) * pose(edge.j).inverse();
  }
  for (const IsotropicEdge<Pose>& edge : graph) {
    values.update(edge.from, move * pose(edge.i));
    values.update(edge.to, move * pose(edge.j));
  }
  return values;
}

template std::vector<IsotropicEdge<SE2>> relative_poses(const std::vector<ContinuousFactorPtr>&,
                                                        IsotropicWeights);
template std::vector<IsotropicEdge<SE3>> relative_poses(const std::vector<ContinuousFactorPtr>&,
                                                        IsotropicWeights);
template IsotropicForm isotropic_form(const std::vector<IsotropicEdge<SE2>>&);
template IsotropicForm isotropic_form(const std::vector<IsotropicEdge<SE3>>&);
template Eigen::MatrixXd stacked(const std::vector<IsotropicEdge<SE2>>&, const Values&);
template Eigen::MatrixXd stacked(const std::vector<IsotropicEdge<SE3>>&, const Values&);
template Values unstacked(const std::vector<IsotropicEdge<SE2>>&, const Eigen::MatrixXd&, Key,
                          Values);
template Values unstacked(const std::vector<IsotropicEdge<SE3>>&, const Eigen::MatrixXd&, Key,
                          Values);

}  // namespace hybrid
