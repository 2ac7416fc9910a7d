// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/map_shift.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"

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

/// Collects runs, in order of time for each robot.
class Runs {
 public:
  void add(std::size_t robot, double time, bool biased, const Eigen::Vector3d& error) {
    Run& run = open_[robot];
    if (run.count > 0 && run.biased != biased) close(robot);
    if (run.count == 0) run.begin = time;
    run.biased = biased;
    run.end = time;
    run.sum += error;
    ++run.count;
  }
  void close_all() {
    while (!open_.empty()) {
      const std::size_t robot = open_.begin()->first;
      close(robot);
      open_.erase(robot);
    }
  }
  const Run& longest_biased() const { return longest_; }
  double good_time() const { return good_time_; }

 private:
  void close(std::size_t robot) {
    const Run run = std::exchange(open_[robot], {});
    if (!run.biased) {
      good_time_ += run.time();
    } else if (run.time() > longest_.time()) {
      longest_ = run;
    }
  }

  std::map<std::size_t, Run> open_;
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

/// The direction from one point of the plane to another; nothing where they are too near.
std::optional<double> direction(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                double least) {
  const Eigen::Vector2d way = (to - from).head<2>();
  if (way.norm() < least) return std::nullopt;
  return std::atan2(way.y(), way.x());
}

/// The heading of a robot by the fixes of a keyframe, from `first` on.
std::optional<double> heading_of(const std::vector<FixEntry>& fixes, std::size_t first,
                                 const Eigen::Isometry3d& T_datum_map) {
  constexpr double kApart = 0.1, kWay = 2;  // m
  constexpr std::size_t kAhead = 1000;      // fixes that are looked at: a robot may stand for hours
  const FixEntry& here = fixes[first];
  const auto place = [&](const FixEntry& e) -> Eigen::Vector3d {
    return T_datum_map.inverse() * e.fix.position;
  };
  const std::size_t end = std::min(fixes.size(), first + kAhead);
  for (std::size_t i = first + 1; i < end; ++i) {
    const FixEntry& there = fixes[i];
    if (there.robot != here.robot) continue;
    const auto turned = direction(place(here), place(there), kApart);
    const auto own = direction(here.fix.lever_arm(), there.fix.lever_arm(), kApart);
    if (there.pose == here.pose) {
      if (turned && own) return *turned - *own;
    } else if (const auto ahead = direction(place(here), place(there), kWay)) {
      return ahead;
    }
  }
  return std::nullopt;
}

}  // namespace

Values poses_at_fixes(const std::vector<FixEntry>& fixes, const Eigen::Isometry3d& T_datum_map,
                      bool is_3d) {
  Values out;
  double heading = 0;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const FixEntry& entry = fixes[i];
    if (!entry.unused.empty() || out.contains(entry.pose)) continue;
    heading = heading_of(fixes, i, T_datum_map).value_or(heading);
    Eigen::Isometry3d T(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()));
    T.translation() =
        T_datum_map.inverse() * entry.fix.position - T.linear() * entry.fix.lever_arm();
    insert_pose(out, entry.pose, T, is_3d);
  }
  return out;
}

std::optional<Values> shift_by_bias(const std::vector<FixEntry>& fixes, const MapView& map) {
  Runs runs;
  for (const FixEntry& entry : fixes) {
    if (!entry.error || map.assignment.find(*entry.falsity) == 1 || !map.holds(*entry.error)) {
      continue;
    }
    const bool biased = is_biased(static_cast<ErrorMode>(map.assignment.at(entry.mode.key)));
    runs.add(entry.robot, entry.fix.time, biased, point_at(map.values, *entry.error));
  }
  runs.close_all();
  const Run& longest = runs.longest_biased();
  if (longest.count == 0 || longest.time() < runs.good_time()) return std::nullopt;
  return shifted(longest.sum / longest.count, map);
}

}  // namespace hybrid
