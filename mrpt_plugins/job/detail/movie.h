// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/path_archive.h"

namespace hybrid {

/// The growing map: estimates after equal shares of the keyframes, drawn in the frame of the last
/// one.
class Movie {
 public:
  /// A film of so many frames of a log with so many keyframes.
  Movie(int frames, std::size_t keyframes) : frames_(frames), keyframes_(keyframes) {}

  /// After each keyframe: keeps the estimate after so many of them if it belongs to a frame.
  void watch(std::size_t keyframes, const Mapper& mapper, const PathArchive& paths);

  /// Ends with the final map.
  void finish(const MapResult& result);

  int size() const { return frames_; }
  /// Frame i in 0 .. size()-1, once finished.
  Image frame(int i, const GroundTruth& truth) const;

  /// Writes frames/frame_0001.png and so on.
  void write_frames(const OutputDirectory& out, const GroundTruth& truth) const;

 private:
  int frames_;
  std::size_t keyframes_;
  struct Scene {
    MapResult map;                   // of dead reckoning, only the last scene has a copy
    std::vector<std::int64_t> seen;  // landmarks that the newest pose sees
  };

  std::vector<Scene> scenes_;              // one per frame
  std::map<std::int64_t, int> sightings_;  // of each landmark, so far
  std::vector<std::int64_t> seen_;         // landmarks that the newest keyframe sees
};

}  // namespace hybrid
