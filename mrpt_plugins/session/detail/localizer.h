// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
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
  double log_likelihood_ratio(std::int64_t id, const std::vector<double>& classes,
                              int of_map) const;
  bool covers(const Eigen::Vector3d& point) const;

  const MapRecord& map_;
  PlaceSearch search_;
  std::vector<int> there_;                         // landmarks of the map that exist
  std::shared_ptr<const PlaceMap<SE2>> in_plane_;  // these, of which there is one
  std::shared_ptr<const PlaceMap<SE3>> in_space_;
  std::vector<double> class_prior_;
  std::vector<Eigen::Vector3d> path_;  // of all sessions
  double reach_ = 0;                   // a landmark nearer to the path was seen as a rule
  bool uses_ids_ = false;              // those of the session are ids of a log, as those of the map
  std::size_t asked_ = 0, waited_ = 0;
};

}  // namespace hybrid
