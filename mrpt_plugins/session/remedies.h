// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// Settings that a bad map is made again with.
struct Remedies {
  bool calibrates = false;  ///< scale and drift of the odometry are estimated
  bool calibration_was_tried = false;
  std::map<std::string, double> factors;  ///< of noise, by key

  /// Adds what a bad map says of its own settings: what may mend them, or else factors of noise.
  /// Returns whether anything changed.
  bool add(const Health& health, const IniFile::Settings& configuration);
  /// The request with the noise measured, and with these settings.
  ReplayRequest apply(ReplayRequest request) const;
};

/// The check that calls a map bad because its landmarks were decided finer than could be told; null
/// if there is none. Landmarks that are near each other may look like copies of each other, so that
/// these count where all are found again.
const char* too_fine(const Health& health);

/// Whether a map is good by a check, and its landmarks are not lost. What was not asked is not
/// good.
bool is_good_by(const char* check, const Health& health);

/// Of paths that were found in different ways, which to believe where nothing else tells: the two
/// that agree best (rmse after alignment, poses of one time) are more probably right than any that
/// stands alone, and the first of these is it. Returns its number; 0 where there are no two.
std::size_t first_of_agreeing(const std::vector<Trajectory>& paths);

/// Whether a check of map `a` is bad and clearly worse than that of map `b`.
bool has_spoilt(const Health& a, const Health& b);

/// The request with landmarks that have an extent, from fine to coarse: what may be of one of them
/// is of it (joint compatibility, which prefers a landmark that is known to a new one). All
/// detections are used, also those between keyframes. None where the map that was made, whose
/// summary this is, did not leave open how detections find landmarks.
std::vector<ReplayRequest> coarser(const ReplayRequest& request, const Summary& summary);

/// The request with things that are seen by direction alone followed for longer. None where the log
/// has no such things, or the request tells how long.
std::vector<ReplayRequest> following_longer(const ReplayRequest& request, const Summary& summary);

/// The request with keyframes farther apart in time, from fine to coarse: errors of detections that
/// last are less alike in them. None where the request, or the log, tells their interval, and for
/// directions, whose crossings need them all.
std::vector<ReplayRequest> sparser(const ReplayRequest& request, const Summary& summary);

/// The request without the fixes of satellite receivers, where the map with them, whose summary
/// this is, does not agree over time or takes many of them for false. Nothing where without them
/// nothing is mapped.
std::optional<ReplayRequest> without_fixes(ReplayRequest request, const Summary& summary);

/// Whether more of what was measured far apart in time agrees in map `a` than in `b`, or as much,
/// and `a` is better otherwise: by the verdict and, of maps that are bad, by the share. A map that
/// is not judged agrees with nothing.
bool agrees_better(const Health& a, const Health& b);

}  // namespace hybrid
