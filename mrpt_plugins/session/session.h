// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/input/log_merge.h"
#include "mrpt_plugins/mapping/detection_archive.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/session/map_place.h"
#include "mrpt_plugins/session/scan_places.h"
#include "mrpt_plugins/session/team.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// One run over the log of a robot, or over those of a team: from where they start to the estimate
/// that they come to.
class Session {
 public:
  /// Opens logs and map file, and finds where the robots start; the settings keep those that are
  /// found. Settings must live as long as this. `doubt` says why the robots are not in the map
  /// file, where an earlier run has told that. Throws as replay does.
  Session(const ReplayRequest& request, ReplaySettings& settings,
          const std::function<Provenance()>& provenance, const std::string& doubt);

  /// Reads the logs once to count their keyframes.
  std::size_t count_keyframes() const;
  /// Makes the mapper and gives it what the map file holds; before all of the following.
  void begin();

  /// Called after every keyframe.
  using Watch = std::function<void(const StepRecord&, const Keyframe&)>;
  /// Feeds the logs to the mapper, until the program is asked to stop, and solves to convergence.
  void map(const Watch& watch);
  /// How scans, or clouds from sensors of a reach [m], agree with those of the map that the robots
  /// are in, or where it has none, detections with its landmarks; without looks where it has
  /// neither.
  Agreement agreement(const std::vector<PlacedScan>& scans, const std::vector<PlacedCloud>& clouds,
                      double reach, const DetectionArchive& detections,
                      const Trajectory& path) const;
  /// Why the robots, once mapped, are not where they were taken to be in the map file, or "".
  std::string doubt(const Agreement& with_map, bool has_views) const;
  /// Nothing of the session enters the map file, for this reason.
  void give_up_place(const std::string& doubt) { place_.give_up(doubt); }
  /// The estimate, with the title of the settings.
  MapResult result() const;
  /// Writes the map file, unless a signal stopped the run; `show` is called when all is written and
  /// nothing shows yet.
  void publish(const MapResult& result, const std::function<void()>& show);

  const LogMerge& source() const { return source_; }
  const Team& team() const { return team_; }
  const MapPlace& place() const { return place_; }
  /// The map before the session where the robots are in it, else an empty one.
  const MapRecord& known() const;
  const Plugins& plugins() const { return plugins_; }
  Mapper& mapper() { return *mapper_; }
  const Mapper& mapper() const { return *mapper_; }
  const BackendReport& last() const { return last_; }
  int signal() const { return signal_; }  ///< that stopped it with keyframes left; 0: none did

 private:
  std::optional<Keyframe> next_keyframe();
  std::vector<std::string> files() const;
  Error no_frame() const;
  void begin_logs();

  ReplaySettings& settings_;
  LogMerge source_;
  bool is_3d_;
  MapPlace place_;
  Team team_;
  Plugins plugins_;
  std::optional<Mapper> mapper_;
  BackendReport last_;
  int signal_ = 0;
};

}  // namespace hybrid
