// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/session/map_run.h"
#include "mrpt_plugins/session/scan_places.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// The place of a replay in a map file; without one, all of this does nothing. Where no robot is
/// found in the map, it is mapped in a frame of its own, and the file stays as it is.
class MapPlace {
 public:
  /// Opens the file. Throws Error, which names it.
  /// `doubt` says why the robots are not in it, where that is known; else it is empty.
  MapPlace(const ReplayRequest& request, const ReplaySettings& settings,
           const std::function<Provenance()>& provenance, bool is_3d, std::string doubt);

  /// The map before the session; without landmarks where there is none, or the robots are not in
  /// it.
  const MapRecord& map() const;
  /// Whether the log is located in a map that stays as it is.
  bool localizes() const { return run_ && run_->localizes() && !lost_; }
  /// The place on the globe of the frame of the session, by hand or as the map has it.
  std::optional<MapOrigin> origin() const;
  /// Gives the mapper the landmarks of the map, before the first keyframe; none where the robots
  /// were not `found` in it.
  void enter(Mapper& mapper, bool found);
  /// Tells that the mapper has one more keyframe.
  void added(const Mapper& mapper);
  /// The replay stops before the end of the log.
  void pause(const Mapper& mapper);
  /// At the end of the log: why robots that were taken to be in the map are not, or "", by how
  /// their scans or clouds agree with it, if there were any.
  std::string doubt(const Agreement& with_map, bool has_views) const;
  /// Takes back what was written of the session for this reason.
  void give_up(const std::string& doubt);
  /// What summary and landmarks have to say of it.
  void tell(MapResult& result, Summary& summary) const;
  /// Whether the map is to be written.
  bool writes() const { return run_ && !lost_; }
  /// Writes the map, with what laser scans and clouds of this session saw. `show` is called when
  /// all is written and nothing shows yet.
  void finish(const Mapper& mapper, const MapResult& result, const SeenPlaces& seen,
              const std::function<void()>& show);

 private:
  MapOptions options_;
  std::optional<MapRun> run_;
  std::string doubt_;
  bool is_given_ = false;  // a start, by the settings
  bool lost_ = false;      // no robot was found in the map
};

}  // namespace hybrid
