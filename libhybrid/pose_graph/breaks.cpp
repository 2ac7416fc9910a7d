// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/breaks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

constexpr double kMostSigma = 1e3;  // to that of most odometry

/// The largest standard deviation in any direction: of the translation [m], of the rotation [rad].
struct Sigmas {
  double translation = 0, rotation = 0;
};

/// One over the root of the least information of a block, with all else known; no inverse is
/// needed, which information of 1e-300 would not have.
double largest_sigma(const Eigen::MatrixXd& information) {
  return 1.0 / std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                                           information, Eigen::EigenvaluesOnly)
                                           .eigenvalues()(0)));
}

template <class Pose>
Sigmas sigmas_of(const GraphEdge<Pose>& edge) {
  constexpr int kPoint = Pose::Point::RowsAtCompileTime;
  constexpr int kRotation = Pose::kDim - kPoint;
  const Eigen::MatrixXd information = edge.noise.information();
  return {largest_sigma(information.topLeftCorner(kPoint, kPoint)),
          largest_sigma(information.bottomRightCorner(kRotation, kRotation))};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Beyond these a relative pose says nothing; none does without odometry.
template <class Pose>
Sigmas limits_of(const std::vector<GraphEdge<Pose>>& edges, const OdometryEdges& is_odometry) {
  std::vector<double> translations, rotations;
  double way = 0;
  for (const GraphEdge<Pose>& edge : edges) {
    if (!is_odometry(edge.from, edge.to)) continue;
    const Sigmas sigmas = sigmas_of(edge);
    translations.push_back(sigmas.translation);
    rotations.push_back(sigmas.rotation);
    way += edge.measured.translation().norm();
  }
  if (translations.empty()) return {};
  return {std::max(way, kMostSigma * median(translations)),
          std::max(M_PI, kMostSigma * median(rotations))};
}

template <class Pose>
void bound(std::vector<GraphEdge<Pose>>& edges, const OdometryEdges& is_odometry,
           std::vector<bool>& breaks) {
  constexpr int kPoint = Pose::Point::RowsAtCompileTime;
  const Sigmas limits = limits_of(edges, is_odometry);
  Eigen::VectorXd least = Eigen::VectorXd::Constant(Pose::kDim, std::pow(limits.rotation, -2));
  least.head(kPoint).setConstant(std::pow(limits.translation, -2));
  for (GraphEdge<Pose>& edge : edges) {
    breaks.push_back(false);
    if (!is_odometry(edge.from, edge.to)) continue;
    const Sigmas sigmas = sigmas_of(edge);
    breaks.back() = sigmas.translation > limits.translation || sigmas.rotation > limits.rotation;
    if (!breaks.back()) continue;
    Eigen::MatrixXd information = edge.noise.information();
    information.diagonal() += least;
    edge.noise = Noise::information(information);
  }
}

}  // namespace

std::vector<bool> bound_breaks(PoseGraph& graph) {
  const OdometryEdges is_odometry(graph);
  std::vector<bool> breaks;
  bound(graph.poses2, is_odometry, breaks);
  bound(graph.poses3, is_odometry, breaks);
  return breaks;
}

}  // namespace hybrid
