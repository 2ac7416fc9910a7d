// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace HYBRID_API hybrid {

/// The setting by which noise, clocks and mountings are measured.
constexpr const char* kMeasuresNoise = "sensor.noise=measured";

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

/// Requests for other maps of logs whose map is bad, in the order in which to try them; `request`
/// is what the user asked for, and `bases` made the best maps so far. Some may be made already.
/// What the user, or the log, has set stays as it is, by the `summary` of the first of these:
/// * scale and drift of the odometry are estimated;
/// * things that are seen by direction alone are followed for longer;
/// * landmarks have an extent, from fine to coarse: what may be of one of them is of it (joint
///   compatibility, which prefers a landmark that is known to a new one), and all detections are
///   used, also those between keyframes;
/// * keyframes are farther apart in time, from fine to coarse: errors of detections that last are
///   less alike in them. Not for directions, whose crossings need them all.
std::vector<ReplayRequest> draws(const ReplayRequest& request, std::vector<ReplayRequest> bases,
                                 const Summary& summary);

/// The request with the noise of receivers and odometry as stated, where fixes of the map whose
/// summary this is are bad.
std::optional<ReplayRequest> with_stated_noise(ReplayRequest request, const Summary& summary);

/// The request without the fixes of satellite receivers, where the map with them, whose summary
/// this is, does not agree over time or takes many of them for false or biased. Nothing where
/// without them nothing is mapped.
std::optional<ReplayRequest> without_fixes(ReplayRequest request, const Summary& summary);

/// Whether clearly more of what was measured far apart in time agrees in map `a` than in `b`, of
/// which not both are good; or as much, and `a` is better by all checks, or by this alone where
/// these do not tell. A map without a bad check is not given up for one that agrees less, and
/// none for one whose calibration is bad where its own is not. A map that is not judged agrees with
/// nothing, but where all other checks call it right it is better than one that is judged bad.
bool agrees_better(const Health& a, const Health& b);

}  // namespace hybrid
