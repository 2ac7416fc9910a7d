// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/views.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/spatial_values.h"

namespace hybrid {
namespace {

/// Those that have left are searched for once there are this share more, so that the search costs
/// each look the same however many there are.
constexpr std::size_t kForgetShare = 16;
constexpr std::size_t kFewLooks = 100;
/// Looks that are counted: what is left after so many is nothing.
constexpr int kMostLooks = 2 * static_cast<int>(DetectionModel::kPriorLooks);

}  // namespace

void Views::add(const KeyframeView& frame, const Eigen::Isometry3d& T_robot_sensor,
                const SensorCoverage& coverage, const MapView& map) {
  View view{frame.pose, T_robot_sensor, coverage, 0, std::max(reach(), coverage.max_range)};
  const Eigen::Vector3d here = frame.T_map_robot.translation();
  if (!views_.empty()) {
    const View& last = views_.back();
    view.travelled = last.travelled;
    if (last.pose != frame.pose && map.values.contains(last.pose)) {
      view.travelled += (here - isometry_at(map.values, last.pose).translation()).norm();
    }
  }
  if (views_.size() >= forget_at_ && map.keeps_all) {
    forget(map, frame.pose);
    forget_at_ = views_.size() + std::max(kFewLooks, views_.size() / kForgetShare);
  }
  places_.put(static_cast<int>(views_.size()), here.x(), here.y());
  views_.push_back(std::move(view));
}

void Views::resize(std::size_t size) {
  for (; views_.size() > size; views_.pop_back()) {
    places_.remove(static_cast<int>(views_.size()) - 1);
  }
}

/// Looks from poses that have left the graph are no longer searched, so that the search grows with
/// the graph and not with the log. A map that keeps all poses loses none.
void Views::forget(const MapView& map, Key newest) {
  for (std::size_t view = 0; view < views_.size(); ++view) {
    const Key pose = views_[view].pose;
    if (pose != newest && !map.holds(pose)) places_.remove(static_cast<int>(view));
  }
}

std::optional<Key> Views::first_near(const Eigen::Vector3d& point, double radius, Key newest,
                                     const MapView& map) const {
  std::size_t first = views_.size();
  visit_near(point, radius, [&](std::size_t view) {
    const Key pose = views_[view].pose;
    if (view < first && pose != newest && map.holds(pose)) first = view;
  });
  if (first == views_.size()) return std::nullopt;
  return views_[first].pose;
}

bool Views::covers(std::size_t view, const Eigen::Vector3d& point, const MapView& map) const {
  const View& look = views_[view];
  return look.coverage.well_in_view(
      compose(isometry_at(map.values, look.pose), look.T_robot_sensor), point);
}

double Views::one_rather_than_two(const Eigen::Vector3d& a, const std::vector<Key>& seen_a,
                                  const Eigen::Vector3d& b, const std::vector<Key>& seen_b,
                                  const DetectionModel& detections, const MapView& map) const {
  if (empty()) return 0.0;
  int looks = 0, hits_a = 0, hits_b = 0, hits = 0;
  visit_near(a, reach(), [&](std::size_t view) {
    const Key pose = views_[view].pose;
    if (!map.holds(pose) || !covers(view, a, map) || !covers(view, b, map)) return;
    const bool of_a = std::binary_search(seen_a.begin(), seen_a.end(), pose);
    const bool of_b = std::binary_search(seen_b.begin(), seen_b.end(), pose);
    ++looks;
    hits_a += of_a ? 1 : 0;
    hits_b += of_b ? 1 : 0;
    hits += of_a || of_b ? 1 : 0;
  });
  return detections.log_probability(hits, looks) - detections.log_probability(hits_a, looks) -
         detections.log_probability(hits_b, looks);
}

/// The mean over the Gaussian by Gauss-Hermite quadrature with three nodes an axis.
double Views::undetected(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                         const DetectionModel& detections, const MapView& map) const {
  if (empty()) return 1.0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  const Eigen::MatrixXd axes =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const auto dim = static_cast<int>(mean.size());
  const int nodes = dim == 3 ? 27 : 9;
  double share = 0;
  for (int node = 0; node < nodes; ++node) {
    Eigen::VectorXd offset(dim);
    double weight = 1;
    for (int k = 0, rest = node; k < dim; ++k, rest /= 3) {
      offset[k] = std::sqrt(3.0) * (rest % 3 - 1);
      weight *= rest % 3 == 1 ? 2.0 / 3 : 1.0 / 6;
    }
    const Eigen::Vector3d point = padded_point(mean + axes * offset);
    int looks = 0;
    visit_near(point, reach(), [&](std::size_t view) {
      const Key pose = views_[view].pose;
      if (looks == kMostLooks || pose == back().pose || !map.holds(pose)) return;
      if (covers(view, point, map)) ++looks;
    });
    share += weight * std::exp(detections.log_probability(0, looks));
  }
  return share;
}

}  // namespace hybrid
