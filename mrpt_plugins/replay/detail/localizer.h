// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/maps/find_place.h"
#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {

/// Finds where in a stored map the robot of a session started, by the landmarks that the session
/// has mapped in a frame of its own.
class Localizer {
 public:
  /// `odds` is the evidence needed for a place. The map must outlive this.
  Localizer(const MapRecord& map, double odds);

  /// Looks after a keyframe, where there is something new; the pose in the map of the first
  /// keyframe, once one place is far more probable than chance and than all others.
  std::optional<KnownStart> look(const Mapper& mapper);

 private:
  template <class Pose>
  std::optional<KnownStart> look_in(const Mapper& mapper);
  template <class Pose>
  PlaceQuestion<Pose> question_about_map() const;
  Eigen::RowVectorXd log_likelihood_ratios(std::int64_t id,
                                           const std::vector<double>& classes) const;
  bool covers(const Eigen::Vector3d& point) const;

  const MapRecord& map_;
  PlaceSearch search_;
  std::vector<int> there_;         // landmarks of the map that exist
  Eigen::MatrixXd covariance_;     // of these together
  Eigen::MatrixXd ratios_in_map_;  // evidence that two of them are one but for where they are
  std::vector<double> class_prior_;
  std::vector<Eigen::Vector3d> path_;  // of all sessions
  double reach_ = 0;                   // a landmark nearer to the path was seen as a rule
  std::size_t asked_ = 0, waited_ = 0;
};

}  // namespace hybrid
