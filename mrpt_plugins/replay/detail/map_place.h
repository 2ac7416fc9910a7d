// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/replay/detail/find_start.h"
#include "mrpt_plugins/replay/detail/map_run.h"
#include "mrpt_plugins/replay/settings.h"

namespace hybrid {

/// The place of a replay in a map file; without one, all of this does nothing. Where the log is
/// not found in the map, it is mapped in a frame of its own, and the file stays as it is.
class MapPlace {
 public:
  /// Opens the file and finds the log in it. Throws Error, which names the file.
  MapPlace(const ReplayRequest& request, const ReplaySettings& settings,
           const std::function<Provenance()>& provenance, bool is_3d);

  /// Where the log starts in the map, if there is one and that is known.
  std::optional<KnownStart> start() const;
  /// Whether the log is located in a map that stays as it is.
  bool localizes() const { return run_ && run_->localizes() && !lost(); }
  /// Gives the mapper the landmarks of the map, before the first keyframe.
  void enter(Mapper& mapper);
  /// Tells that keyframe number `keyframe` is in the mapper.
  void added(std::size_t keyframe, Mapper& mapper);
  /// The replay stops before the end of the log.
  void pause(const Mapper& mapper);
  /// What summary and landmarks have to say of it.
  void tell(MapResult& result, Summary& summary) const;
  /// Writes the map. `show` is called when all is written and nothing shows yet.
  void finish(const Mapper& mapper, const MapResult& result, const std::function<void()>& show);

 private:
  bool lost() const { return run_ && !run_->map().landmarks.empty() && !found_; }

  MapOptions options_;
  std::optional<MapRun> run_;
  std::optional<FoundStart> found_;
  bool given_ = false;  // the start, by the settings
};

}  // namespace hybrid
