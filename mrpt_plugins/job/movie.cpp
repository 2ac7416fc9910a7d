// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/movie.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/map_style.h"

namespace hybrid {
namespace {

/// What a landmark stands for in the end, as nothing counts it before.
LandmarkSize size_of(std::int64_t id, const MapResult& result) {
  const auto it =
      std::find_if(result.landmarks.begin(), result.landmarks.end(),
                   [id](const LandmarkEstimate& landmark) { return landmark.id == id; });
  return it == result.landmarks.end() ? LandmarkSize() : it->size;
}

}  // namespace

void Movie::watch(std::size_t keyframes, const Mapper& mapper, const PathArchive& paths) {
  seen_.clear();
  for (const auto& [id, landmark] : mapper.landmarks()) {
    int& before = sightings_[id];
    if (landmark.sightings > before) seen_.push_back(id);
    before = landmark.sightings;
  }
  const auto frames = static_cast<std::size_t>(frames_);
  const std::size_t due = std::min(frames - 1, keyframes * frames / keyframes_);
  if (scenes_.size() >= due) return;
  MapResult scene = mapper.result_without_sizes();
  scene.curves = paths.curves(scene.trajectory);
  scene.dead_reckoning.clear();
  scene.steps.clear();
  scenes_.resize(due, {std::move(scene), seen_});
}

void Movie::finish(const MapResult& result) {
  scenes_.resize(static_cast<std::size_t>(frames_), {result, seen_});
}

Image Movie::frame(int i, const GroundTruth& truth) const {
  const std::size_t at = static_cast<std::size_t>(i);
  MapResult scene = scenes_.at(at).map;
  const MapResult& last = scenes_.back().map;
  scene.title = last.title;
  for (LandmarkEstimate& landmark : scene.landmarks) landmark.size = size_of(landmark.id, last);
  const auto poses = static_cast<std::ptrdiff_t>(scene.trajectory.size());
  scene.dead_reckoning.assign(last.dead_reckoning.begin(), last.dead_reckoning.begin() + poses);
  scene.reckoned_curves = last.reckoned_curves;
  if (poses < static_cast<std::ptrdiff_t>(last.trajectory.size())) {
    scene.reckoned_curves.after.clear();
  }
  const double seconds =
      scene.trajectory.empty() ? 0 : scene.trajectory.back().time - last.trajectory.front().time;
  return map_image(scene, truth, 1600, 1200, map_frame(last, truth),
                   {fmt::format("after {:.1f} s, ", seconds), scenes_[at].seen});
}

void Movie::write_frames(const OutputDirectory& out, const GroundTruth& truth) const {
  for (int i = 0; i < frames_; ++i) {
    out.write(fmt::format("frames/frame_{:04}.png", i + 1), png(frame(i, truth)));
  }
}

}  // namespace hybrid
