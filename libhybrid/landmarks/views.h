// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/association/spatial_grid.h"
#include "libhybrid/detections/detection_model.h"
#include "libhybrid/detections/sensor_coverage.h"
#include "libhybrid/landmarks/contribution.h"

namespace HYBRID_API hybrid {

/// One look of a sensor.
struct View {
  Key pose;
  Eigen::Isometry3d T_robot_sensor;
  SensorCoverage coverage;
  double travelled;  ///< so far [m]
  double reach;      ///< the farthest range of any sensor so far [m]
};

/// All looks of the sensors so far, in order.
class Views {
 public:
  /// Notes a look from a keyframe, `map` being that of its frame.
  void add(const KeyframeView& frame, const Eigen::Isometry3d& T_robot_sensor,
           const SensorCoverage& coverage, const MapView& map);

  /// Goes back to the first so many looks.
  void resize(std::size_t size);

  bool empty() const { return views_.empty(); }
  std::size_t size() const { return views_.size(); }
  const View& operator[](std::size_t view) const { return views_[view]; }
  const View& back() const { return views_.back(); }

  /// The farthest range of any sensor so far [m]: looks from farther away show nothing.
  double reach() const { return empty() ? 0 : back().reach; }

  /// Calls visit(view) for those whose robot was about `radius` from a point when it looked.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& point, double radius, const Visit& visit) const {
    places_.visit_near(point.x(), point.y(), radius,
                       [&](int view) { visit(static_cast<std::size_t>(view)); });
  }

  /// The pose of the first look from about `radius` around a point, other than `newest`, that the
  /// map still holds; none if there is none.
  std::optional<Key> first_near(const Eigen::Vector3d& point, double radius, Key newest,
                                const MapView& map) const;

  /// Whether a point of the map was well in view in a look, which the map still holds.
  bool covers(std::size_t view, const Eigen::Vector3d& point, const MapView& map) const;

  /// log odds that two landmarks are one and not two, by what looks saw of them: of the looks that
  /// had both well in view, those from the poses `seen_a` and `seen_b`, each in ascending order,
  /// saw the one and the other.
  double one_rather_than_two(const Eigen::Vector3d& a, const std::vector<Key>& seen_a,
                             const Eigen::Vector3d& b, const std::vector<Key>& seen_b,
                             const DetectionModel& detections, const MapView& map) const;

  /// The share of landmarks that are still undetected where a landmark may be, a Gaussian, after
  /// all looks there before the newest keyframe: 1 where nobody looked.
  double undetected(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                    const DetectionModel& detections, const MapView& map) const;

 private:
  void forget(const MapView& map, Key newest);

  std::vector<View> views_;
  std::size_t forget_at_ = 0;  // looks
  SpatialGrid places_;
};

}  // namespace hybrid
