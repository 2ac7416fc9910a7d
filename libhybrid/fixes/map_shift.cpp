// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/map_shift.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/fixes/fix_model.h"

namespace hybrid {
namespace {

/// Fixes of a receiver that follow each other, all biased or none.
struct Run {
  bool biased = false;
  double begin = 0, end = 0;  // s
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;

  double time() const { return end - begin; }
};

/// Collects runs, in order of time for each receiver.
class Runs {
 public:
  void add(const ReceiverId& id, double time, bool biased, const Eigen::Vector3d& error) {
    Run& run = open_[id];
    if (run.count > 0 && run.biased != biased) close(run);
    if (run.count == 0) run.begin = time;
    run.biased = biased;
    run.end = time;
    run.sum += error;
    ++run.count;
  }
  void close_all() {
    for (auto& [id, run] : open_) close(run);
    open_.clear();
  }
  const Run& longest_biased() const { return longest_; }
  double good_time() const { return good_time_; }

 private:
  void close(Run& open) {
    const Run run = std::exchange(open, {});
    if (!run.biased) {
      good_time_ += run.time();
    } else if (run.time() > longest_.time()) {
      longest_ = run;
    }
  }

  std::map<ReceiverId, Run> open_;
  Run longest_;
  double good_time_ = 0;
};

Values shifted(const Eigen::Vector3d& shift, const MapView& map) {
  Values out;
  for (const Key key : map.values.keys()) {
    if (!map.holds(key)) continue;
    const char letter = key.letter();
    if (letter == key_letter::kPose) {
      insert_pose(out, key, Eigen::Translation3d(shift) * isometry_at(map.values, key), map.is_3d);
    } else if (letter == key_letter::kLandmark) {
      insert_point(out, key, point_at(map.values, key) + shift, map.is_3d);
    } else if (letter == key_letter::kFixError) {
      insert_point(out, key, point_at(map.values, key) - shift, map.is_3d);
    }
  }
  return out;
}

/// The direction of a way in the plane; nothing where it is too short.
std::optional<double> direction(const Eigen::Vector3d& way, double least) {
  if (way.head<2>().norm() < least) return std::nullopt;
  return std::atan2(way.y(), way.x());
}

/// Of each robot, the receiver that has most fixes in the map.
std::map<std::size_t, ReceiverId> main_receivers(const std::vector<FixEntry>& fixes) {
  std::map<ReceiverId, std::size_t> counts;
  for (const FixEntry& entry : fixes) counts[entry.receiver()] += entry.unused.empty() ? 1 : 0;
  std::map<std::size_t, ReceiverId> out;
  for (const auto& [id, count] : counts) {
    const auto [best, is_first] = out.emplace(id.first, id);
    if (!is_first && count > counts.at(best->second)) best->second = id;
  }
  return out;
}

/// The heading of a robot whose antennas are where two fixes of a keyframe say; nothing where these
/// are not as far apart as the antennas are.
std::optional<double> heading_by_antennas(const FixEntry& here, const FixEntry& there,
                                          const Eigen::Vector3d& way) {
  constexpr double kApart = 0.1;  // m
  constexpr double kFits = 0.5;   // share of the distance of the antennas, half a radian
  const Eigen::Vector3d arm = there.fix.lever_arm() - here.fix.lever_arm();
  const auto turned = direction(way, kApart);
  const auto own = direction(arm, kApart);
  if (!turned || !own) return std::nullopt;
  const double apart = way.head<2>().norm(), stated = arm.head<2>().norm();
  if (std::abs(apart - stated) > kFits * stated) return std::nullopt;
  return *turned - *own;
}

/// The heading of a robot by the fixes of its main receiver from `first` on, and by those of others
/// in the same keyframe.
std::optional<double> heading_of(const std::vector<FixEntry>& fixes, std::size_t first,
                                 const Eigen::Isometry3d& T_datum_map) {
  constexpr double kWay = 2;            // m
  constexpr std::size_t kAhead = 1000;  // fixes that are looked at: a robot may stand for hours
  const FixEntry& here = fixes[first];
  const std::size_t end = std::min(fixes.size(), first + kAhead);
  for (std::size_t i = first + 1; i < end; ++i) {
    const FixEntry& there = fixes[i];
    if (there.robot != here.robot) continue;
    const Eigen::Vector3d way =
        T_datum_map.linear().transpose() * (there.fix.position - here.fix.position);
    if (there.pose == here.pose) {
      if (const auto heading = heading_by_antennas(here, there, way)) return heading;
    } else if (there.fix.sensor == here.fix.sensor) {
      if (const auto ahead = direction(way, kWay)) return ahead;
    }
  }
  return std::nullopt;
}

/// Keyframes that have fixes of other receivers alone: where the one before is, or else the one
/// after.
void insert_poses_between(const std::vector<FixEntry>& fixes, bool is_3d, Values& poses) {
  std::map<std::size_t, Key> nearest;  // by robot
  const auto fill = [&](const FixEntry& entry) {
    if (!entry.unused.empty()) return;
    const auto found = nearest.find(entry.robot);
    if (!poses.contains(entry.pose)) {
      if (found == nearest.end()) return;
      insert_pose(poses, entry.pose, isometry_at(poses, found->second), is_3d);
    }
    nearest[entry.robot] = entry.pose;
  };
  std::for_each(fixes.begin(), fixes.end(), fill);
  nearest.clear();
  std::for_each(fixes.rbegin(), fixes.rend(), fill);
}

}  // namespace

Values poses_at_fixes(const std::vector<FixEntry>& fixes, const Eigen::Isometry3d& T_datum_map,
                      bool is_3d) {
  const std::map<std::size_t, ReceiverId> mains = main_receivers(fixes);
  Values out;
  double heading = 0;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const FixEntry& entry = fixes[i];
    if (!entry.unused.empty() || out.contains(entry.pose)) continue;
    if (entry.receiver() != mains.at(entry.robot)) continue;
    heading = heading_of(fixes, i, T_datum_map).value_or(heading);
    Eigen::Isometry3d T(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()));
    T.translation() =
        T_datum_map.inverse() * entry.fix.position - T.linear() * entry.fix.lever_arm();
    insert_pose(out, entry.pose, T, is_3d);
  }
  insert_poses_between(fixes, is_3d, out);
  return out;
}

std::optional<Values> shift_by_bias(const std::vector<FixEntry>& fixes, const MapView& map) {
  Runs runs;
  for (const FixEntry& entry : fixes) {
    if (!entry.error || map.assignment.find(*entry.falsity) == 1 || !map.holds(*entry.error)) {
      continue;
    }
    const bool biased = is_biased(static_cast<ErrorMode>(map.assignment.at(entry.mode.key)));
    runs.add(entry.receiver(), entry.fix.time, biased, point_at(map.values, *entry.error));
  }
  runs.close_all();
  const Run& longest = runs.longest_biased();
  if (longest.count == 0 || longest.time() < runs.good_time()) return std::nullopt;
  return shifted(longest.sum / longest.count, map);
}

}  // namespace hybrid
