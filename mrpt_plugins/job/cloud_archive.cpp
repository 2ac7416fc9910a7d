// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/cloud_archive.h"

#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/clouds.h"

namespace hybrid {
namespace {

constexpr double kViewSpacing = 0.03;  // of the reach

}  // namespace

void CloudArchive::add(std::size_t number, const Keyframe& keyframe) {
  DropReport dropped;  // of which the mapping tells
  for (const auto& observation : keyframe.observations) {
    if (!is_cloud(*observation)) continue;
    if (clouds_++ % stride_ != 0) continue;
    const auto cloud = cloud_in(*observation, dropped);
    if (!cloud) continue;
    if (reach_ == 0) reach_ = reach_of(cloud->points, cloud->sensor);
    if (reach_ == 0) continue;
    entries_.push_back({number, std::make_shared<const CloudView>(cloud->points, cloud->sensor,
                                                                  kViewSpacing * reach_)});
  }
  if (entries_.size() > kMost) thin_out();
}

/// Gives up every second view.
void CloudArchive::thin_out() {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries_.size(); i += 2) entries_[kept++] = entries_[i];
  entries_.resize(kept);
  stride_ *= 2;
}

std::vector<PlacedCloud> CloudArchive::placed(const Mapper& mapper,
                                              const Trajectory& keyframes) const {
  std::vector<PlacedCloud> out;
  for (const Entry& entry : entries_) {
    const TimedPose& at = keyframes[entry.keyframe];
    out.push_back({at.time, static_cast<int>(mapper.robot_of(entry.keyframe)),
                   to_se3(to_isometry(at.pose)), entry.view.get()});
  }
  return out;
}

}  // namespace hybrid
