// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/initialization/pending_landmarks.h"

#include <algorithm>
#include <utility>

#include "libhybrid/core/spatial_values.h"

namespace hybrid {

FrameValues::FrameValues(const KeyframeView& frame, const MapView& map) : map_(map.values) {
  insert_pose(newest_, frame.pose, frame.T_map_robot, map.is_3d);
}

const double* FrameValues::operator()(Key key) const {
  return newest_.contains(key) ? newest_.data(key) : map_.data(key);
}

void PendingLandmarks::add(std::int64_t id, GaussianSumInitializer::Measurement measurement,
                           const BankOptions& options,
                           const std::function<std::vector<Eigen::VectorXd>()>& candidates) {
  auto it = unplaced_.find(id);
  if (it == unplaced_.end())
    it = unplaced_.emplace(id, Unplaced{GaussianSumInitializer(candidates())}).first;
  if (it->second.initializer.needs_candidates())
    it->second.initializer.add_candidates(candidates());
  it->second.initializer.add(std::move(measurement), options);
  it->second.last_measured = calls_;
  ++it->second.measured;
  touched_.insert(id);
}

std::vector<PlacedLandmark> PendingLandmarks::place(const KeyframeView& frame, const MapView& map,
                                                    const BankOptions& options) {
  const FrameValues values(frame, map);
  std::vector<PlacedLandmark> placed;
  for (const std::int64_t id : touched_) {
    GaussianSumInitializer& initializer = unplaced_.at(id).initializer;
    initializer.refine([&](Key key) { return values(key); }, options);
    const auto point = initializer.decided(options);
    if (!point) continue;
    placed.push_back({id, *point, initializer.measurements()});
    unplaced_.erase(id);
  }
  touched_.clear();
  ++calls_;
  return placed;
}

std::map<std::string, int> PendingLandmarks::unplaced(const BankOptions& options) const {
  std::map<std::string, int> counts;
  for (const auto& [id, landmark] : unplaced_) {
    const char* why = landmark.initializer.undecided(options);
    counts[why == nullptr ? "it was to be placed next" : why] += landmark.measured;
  }
  return counts;
}

bool PendingLandmarks::measured_lately(std::size_t calls) const {
  return std::any_of(unplaced_.begin(), unplaced_.end(), [&](const auto& entry) {
    return entry.second.last_measured + calls >= calls_;
  });
}

}  // namespace hybrid
