// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/detail/quantile.h"
#include "mrpt_plugins/health/detail/run_facts.h"

namespace hybrid {
namespace {

constexpr std::size_t kFewestLandmarks = 5, kFewestLooks = 5;
/// Another landmark of the class within this distance is a chance of so much, where landmarks are
/// spread over the map without order.
constexpr double kChance = 0.2;
constexpr UpperLimits kCopyLimits{0.1, 0.2};  // copies to each thing
/// A landmark in view should be seen; from half of the times on it is usual.
constexpr double kSeenDoubtful = 0.5, kSeenBad = 0.25;
constexpr UpperLimits kLostLimits{0.1, 0.2};  // share of landmarks
constexpr double kByChance = 1e-3;            // that so many looks miss a landmark that is there

/// The directions and ranges that most detections come from.
struct View {
  double farthest = 0, rightmost = 0, leftmost = 0;
  bool contains(const Eigen::Isometry3d& T_map_robot, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d p = T_map_robot.inverse() * point;
    const double yaw = std::atan2(p.y(), p.x());
    return p.norm() < farthest && yaw > rightmost && yaw < leftmost;
  }
};

View view_of(const std::vector<FactOfSighting>& sightings) {
  std::vector<double> ranges, yaws;
  for (const FactOfSighting& s : sightings) {
    ranges.push_back(s.range);
    yaws.push_back(s.yaw);
  }
  return {quantile(ranges, 0.9), quantile(yaws, 0.05), quantile(yaws, 0.95)};
}

/// Keyframes that had a landmark in view before it was first seen, between its first and its last
/// sighting, and after that; and those of the middle ones that saw it.
struct Looks {
  std::size_t before = 0, between = 0, after = 0, seen = 0;
  double share() const { return static_cast<double>(seen) / static_cast<double>(between); }
};

std::vector<Looks> looks_at(const RunFacts& facts, const View& view) {
  const std::size_t count = facts.run.result.trajectory.size();
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < count; ++i) poses.push_back(facts.pose(i));
  std::vector<Looks> out;
  for (const LandmarkEstimate& landmark : facts.run.result.landmarks) {
    const auto found = facts.seen_from.find(landmark.id);
    if (found == facts.seen_from.end()) continue;
    const std::set<std::size_t>& seen = found->second;
    Looks looks;
    for (std::size_t i = 0; i < count; ++i) {
      if (!view.contains(poses[i], landmark.position)) continue;
      ++(i < *seen.begin() ? looks.before : i > *seen.rbegin() ? looks.after : looks.between);
      looks.seen += seen.count(i);
    }
    out.push_back(looks);
  }
  return out;
}

/// The share of looks that see the usual landmark; nothing where few were looked at often.
std::optional<double> usual_share(const std::vector<Looks>& looks) {
  std::vector<double> shares;
  for (const Looks& l : looks) {
    if (l.between >= kFewestLooks) shares.push_back(l.share());
  }
  if (shares.size() < kFewestLandmarks) return std::nullopt;
  return quantile(shares, 0.5);
}

/// Whether two landmarks at one place were seen together as two things there would be: where one is
/// seen the other is in view. A thing that was mapped twice is now the one, now the other.
bool were_seen_together(const std::set<std::size_t>& a, const std::set<std::size_t>& b) {
  const auto together =
      std::count_if(a.begin(), a.end(), [&](std::size_t i) { return b.count(i) != 0; });
  return static_cast<double>(together) >=
         kSeenBad * static_cast<double>(std::min(a.size(), b.size()));
}

/// Area that the landmarks cover [m^2], at least that of one metre.
double covered_area(const std::vector<LandmarkEstimate>& landmarks) {
  Eigen::Vector2d low = landmarks.front().position.head<2>(), high = low;
  for (const LandmarkEstimate& l : landmarks) {
    low = low.cwiseMin(l.position.head<2>());
    high = high.cwiseMax(l.position.head<2>());
  }
  return (high - low).cwiseMax(1.0).prod();
}

/// Landmarks that have an earlier one of their class so near that chance hardly puts it there, with
/// which they were hardly seen together.
std::size_t count_copies(const RunFacts& facts) {
  const auto& landmarks = facts.run.result.landmarks;
  const double area = covered_area(landmarks);
  std::map<std::optional<int>, std::size_t> of_class;
  for (const LandmarkEstimate& l : landmarks) ++of_class[l.class_index];
  std::size_t copies = 0;
  for (std::size_t a = 0; a < landmarks.size(); ++a) {
    const auto seen = facts.seen_from.find(landmarks[a].id);
    if (seen == facts.seen_from.end()) continue;
    const double near = std::sqrt(kChance * area /
                                  (M_PI * static_cast<double>(of_class[landmarks[a].class_index])));
    for (std::size_t b = 0; b < a; ++b) {
      if (landmarks[b].class_index != landmarks[a].class_index) continue;
      if ((landmarks[a].position - landmarks[b].position).norm() >= near) continue;
      const auto other = facts.seen_from.find(landmarks[b].id);
      if (other == facts.seen_from.end() || were_seen_together(seen->second, other->second))
        continue;
      ++copies;
      break;
    }
  }
  return copies;
}

HealthEntry entry_on_copies(std::size_t copies, std::size_t landmarks) {
  const auto others = static_cast<double>(std::max<std::size_t>(1, landmarks - copies));
  return judged_entry(
      "copies of landmarks", static_cast<double>(copies) / others, kCopyLimits,
      fmt::format("{} of {} landmarks are so near to another of their class, without being seen "
                  "together with it, that they may be the same thing mapped twice.",
                  copies, landmarks),
      "[sensor] sigma_range and sigma_yaw_deg: larger, until the copies go");
}

HealthEntry entry_on_looks(double usual) {
  HealthEntry entry;
  entry.name = "landmarks seen when in view";
  entry.value = usual;
  entry.least = kSeenDoubtful;
  entry.most = 1;
  entry.verdict = usual < kSeenBad        ? HealthVerdict::kBad
                  : usual < kSeenDoubtful ? HealthVerdict::kDoubtful
                                          : HealthVerdict::kGood;
  entry.sentence = fmt::format(
      "Between its first and its last sighting, the usual landmark was seen at {:.0f} % of the "
      "keyframes that had it in view.",
      100 * usual);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob =
        "sign and unit of the bearings, pose of the sensor on the robot, ids that do not return "
        "([sensor] ids = none), noise of the detections";
  }
  return entry;
}

HealthEntry entry_on_lost(const std::vector<Looks>& looks, double usual) {
  const double hidden = 1 - std::clamp(usual, kSeenBad, 0.99);
  const auto sure = static_cast<std::size_t>(std::ceil(std::log(kByChance) / std::log(hidden)));
  const auto lost = std::count_if(looks.begin(), looks.end(), [&](const Looks& l) {
    return std::max(l.before, l.after) >= std::max(sure, kFewestLooks);
  });
  return judged_entry(
      "landmarks seen at one time only",
      static_cast<double>(lost) / static_cast<double>(looks.size()), kLostLimits,
      fmt::format("{} of {} landmarks were often in view before they were first seen, or after "
                  "they were last seen.",
                  lost, looks.size()),
      "noise of the odometry and of the detections; what is seen again may have become another "
      "landmark");
}

}  // namespace

void check_landmarks(const RunFacts& facts, Health& health) {
  const auto& landmarks = facts.run.result.landmarks;
  if (landmarks.size() < kFewestLandmarks || facts.sightings.empty()) return;
  if (facts.run.associates) {
    health.push_back(entry_on_copies(count_copies(facts), landmarks.size()));
  }
  const std::vector<Looks> looks = looks_at(facts, view_of(facts.sightings));
  const std::optional<double> usual = usual_share(looks);
  if (!usual) return;
  health.push_back(entry_on_looks(*usual));
  health.push_back(entry_on_lost(looks, *usual));
}

}  // namespace hybrid
