// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// What a landmark stands for: one thing, or several that were not told apart.
struct LandmarkSize {
  double extent = 0;  ///< how far from it they are, a standard deviation along each axis [m]
  int things = 1;
};

/// A landmark that is known before the first keyframe.
struct KnownLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2]
  std::vector<double> class_probabilities;               ///< empty: it has no class
  double existence = 0;                                  ///< log odds that it is there
  int sightings = 0;                                     ///< before
  LandmarkSize size;
};

/// Landmarks that are known before the first keyframe, by ascending id.
struct KnownMap {
  bool identified = true;  ///< the ids are those of logs, else numbers of the program that made it
  std::vector<std::string> class_names;
  std::vector<KnownLandmark> landmarks;
  /// On their positions, Key(key_letter::kLandmark, id): what is known of them together.
  std::vector<ContinuousFactorPtr> prior;
};

}  // namespace hybrid
