// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/lasting_ids.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>

#include "libhybrid/core/detail/quantile.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr double kAbsence = 5;      // s, longer than trackers keep what they do not see
constexpr std::size_t kLooks = 10;  // frames with a place in view, in which it would be seen
constexpr std::size_t kFewestIds = 10;
constexpr std::size_t kMostChecks = 2000000;  // of places against frames: a tenth of a second

struct IdLife {
  double last = 0;  // s
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  std::size_t looks = 0;  // since then
  bool again = false, returned = false, due = false;
};

/// Ranges and angles at which a sensor detects most of what it does.
struct View {
  double nearest = 0, farthest = 0, right = 0, left = 0;
  bool contains(const Eigen::Vector3d& z) const {
    return z[0] > nearest && z[0] < farthest && z[1] > right && z[1] < left;
  }
};

View view_of(const std::vector<MovedSightings>& frames) {
  std::vector<double> ranges, yaws;
  for (const MovedSightings& frame : frames) {
    for (const MeasuredPoint& m : frame.sightings.seen) {
      ranges.push_back(m.z[0]);
      yaws.push_back(m.z[1]);
    }
  }
  if (ranges.empty()) return {};
  return {quantile(ranges, 0.1), quantile(ranges, 0.8), quantile(yaws, 0.1), quantile(yaws, 0.9)};
}

Eigen::Vector3d sighted_place(const MovedSightings& frame, const Eigen::VectorXd& z) {
  Eigen::Vector3d polar = Eigen::Vector3d::Zero();
  polar.head(z.size()) = z;
  return frame.T_odometry_robot * (frame.sightings.T_robot_sensor * from_polar(polar));
}

}  // namespace

std::optional<double> IdReturns::share() const {
  if (due >= kFewestIds) return static_cast<double>(returned) / static_cast<double>(due);
  if (ids >= kFewestIds) return static_cast<double>(again) / static_cast<double>(ids);
  return std::nullopt;
}

IdReturns count_id_returns(const std::vector<MovedSightings>& frames) {
  std::map<std::int64_t, IdLife> lives;
  const View view = view_of(frames);
  std::size_t checks = 0;
  for (const MovedSightings& frame : frames) {
    const double time = frame.sightings.time;
    for (std::size_t k = 0; k < frame.ids.size(); ++k) {
      if (!frame.ids[k]) continue;
      const auto [it, is_new] = lives.try_emplace(*frame.ids[k]);
      IdLife& life = it->second;
      if (!is_new) life.again = true;
      if (!is_new && time - life.last > kAbsence) life.returned = true;
      life.last = time;
      life.place = sighted_place(frame, frame.sightings.seen[k].z);
      life.looks = 0;
    }
    if (checks > kMostChecks) continue;
    const SE3 T_sensor_odometry =
        (frame.T_odometry_robot * frame.sightings.T_robot_sensor).inverse();
    for (auto& [id, life] : lives) {
      ++checks;
      if (life.due || life.returned || time - life.last <= kAbsence) continue;
      if (!view.contains(to_polar(Eigen::Vector3d(T_sensor_odometry * life.place)))) continue;
      if (++life.looks >= kLooks) life.due = true;
    }
  }
  IdReturns out;
  out.ids = lives.size();
  for (const auto& [id, life] : lives) {
    if (life.again) ++out.again;
    if (life.due) ++out.due;
    if (life.returned) ++out.returned;
  }
  out.due += out.returned;
  return out;
}

}  // namespace hybrid
