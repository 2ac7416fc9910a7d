// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <vector>

#include "libhybrid/clouds/cloud_surfaces.h"

namespace HYBRID_API hybrid {

/// What one cloud tells about any place: whether a surface is there, or nothing is. All is in the
/// frame of the robot.
class CloudView {
 public:
  /// `spacing`: of the points that are kept [m]; at most 2,500 are.
  CloudView(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor,
            double spacing);

  /// Whether a surface with that normal is at a place; nothing where it is hidden, or out of view.
  std::optional<bool> finds(const Eigen::Vector3f& position, const Eigen::Vector3f& normal) const;

  /// Surfaces that were seen.
  const std::vector<CloudPoint>& surfaces() const { return surfaces_.points(); }
  const Eigen::Vector3f& sensor() const { return sensor_; }

 private:
  static constexpr int kColumns = 90, kRows = 45;  // of directions, four degrees each
  static int cell_of(const Eigen::Vector3f& ray);

  CloudSurfaces surfaces_;
  Eigen::Vector3f sensor_;
  std::vector<float> shortest_;  // of the returns in a direction [m]; infinite: none
};

}  // namespace hybrid
