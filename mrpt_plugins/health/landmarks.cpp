// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/uncertainty/lasting_ids.h"
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
/// Walls hide things from elsewhere: a look counts from where a landmark was seen from, within so
/// much of the range of view.
constexpr double kSameStand = 0.25;

/// The directions and ranges that most detections come from, seen from the robot.
struct View {
  double farthest = 0, middle = 0, rightmost = 0, leftmost = 0;  // the last two from the middle on
  bool contains(const Eigen::Isometry3d& T_map_robot, const Eigen::Vector3d& point) const {
    const Eigen::Vector3d p = T_map_robot.inverse() * point;
    const double yaw = wrap_angle(std::atan2(p.y(), p.x()) - middle);
    return p.norm() < farthest && yaw > rightmost && yaw < leftmost;
  }
};

View view_of(const std::vector<FactOfSighting>& sightings) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const FactOfSighting& s : sightings)
    sum += Eigen::Vector2d(std::cos(s.yaw), std::sin(s.yaw));
  const double middle = std::atan2(sum.y(), sum.x());
  std::vector<double> ranges, yaws;
  for (const FactOfSighting& s : sightings) {
    ranges.push_back(s.range);
    yaws.push_back(wrap_angle(s.yaw - middle));
  }
  return {quantile(ranges, 0.9), middle, quantile(yaws, 0.05), quantile(yaws, 0.95)};
}

/// Keyframes of a detector in the graph that had a landmark in view between its first and its last
/// sighting, and those of them that saw it; and those before and after that looked from about where
/// it was seen from.
struct Looks {
  std::size_t before = 0, between = 0, after = 0, seen = 0;
  double share() const { return static_cast<double>(seen) / static_cast<double>(between); }
};

/// Whether sightings of a landmark have left the graph: the oldest, so that nothing tells when it
/// was first seen.
bool has_left(const LandmarkEstimate& landmark, const RunFacts& facts) {
  const auto is_of_it = [&](const FactOfSighting& s) { return s.landmark == landmark.id; };
  return facts.in_graph.size() < facts.run.result.trajectory.size() &&
         std::count_if(facts.sightings.begin(), facts.sightings.end(), is_of_it) <
             landmark.sightings;
}

std::vector<Looks> looks_at(const RunFacts& facts, const View& view) {
  const std::size_t count = facts.run.result.trajectory.size();
  std::vector<Eigen::Isometry3d> poses;
  for (std::size_t i = 0; i < count; ++i) poses.push_back(facts.pose(i));
  std::vector<Looks> out;
  for (const LandmarkEstimate& landmark : facts.run.result.landmarks) {
    const auto found = facts.seen_from.find(landmark.id);
    if (found == facts.seen_from.end()) continue;
    const std::set<std::size_t>& seen = found->second;
    const auto is_near = [&](std::size_t i) {
      return std::any_of(seen.begin(), seen.end(), [&](std::size_t k) {
        return k < count && (poses[k].translation() - poses[i].translation()).norm() <
                                kSameStand * view.farthest;
      });
    };
    Looks looks;
    for (const std::size_t i : facts.looked_from) {
      if (i >= count || !view.contains(poses[i], landmark.position)) continue;
      const bool between = i >= *seen.begin() && i <= *seen.rbegin();
      if (!between && !is_near(i)) continue;
      ++(between ? looks.between : i < *seen.begin() ? looks.before : looks.after);
      looks.seen += seen.count(i);
    }
    if (looks.before > 0 && has_left(landmark, facts)) looks.before = 0;
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

/// Whether landmarks at one place were seen together as so many things there would be: where two
/// are seen each of the others is as often as `usual`. Of a thing that was mapped twice it is now
/// the one, now the other.
bool were_seen_together(const std::vector<const std::set<std::size_t>*>& landmarks, double usual) {
  std::size_t together = 0, fewest = landmarks.front()->size();
  for (const std::size_t i : *landmarks.front()) {
    const bool all = std::all_of(landmarks.begin(), landmarks.end(),
                                 [i](const auto* seen) { return seen->count(i) != 0; });
    together += all ? 1 : 0;
  }
  for (const auto* seen : landmarks) fewest = std::min(fewest, seen->size());
  return static_cast<double>(together) >=
         kSeenBad * std::pow(usual, static_cast<double>(landmarks.size() - 2)) *
             static_cast<double>(fewest);
}

/// Area that the landmarks cover [m^2], at least that of one metre.
double covered_area(const std::vector<LandmarkEstimate>& landmarks) {
  const auto position = [](const LandmarkEstimate& l) -> Eigen::Vector2d {
    return l.position.head<2>();
  };
  return box_of(landmarks, position).sizes().cwiseMax(1.0).prod();
}

/// Landmarks that have others of their class, seen more often, so near that chance hardly puts them
/// there, with all of which they were hardly seen together: two things there may be, but then they
/// are seen two at a time.
std::size_t count_copies(const RunFacts& facts, double usual) {
  const double area = covered_area(facts.run.result.landmarks);
  struct Seen {
    const LandmarkEstimate* landmark;
    const std::set<std::size_t>* from;
  };
  std::map<std::optional<int>, std::vector<Seen>> of_class;
  for (const LandmarkEstimate& l : facts.run.result.landmarks) {
    const auto found = facts.seen_from.find(l.id);
    if (found != facts.seen_from.end()) of_class[l.class_index].push_back({&l, &found->second});
  }
  std::size_t copies = 0;
  for (auto& [class_index, all] : of_class) {
    std::stable_sort(all.begin(), all.end(),
                     [](const Seen& a, const Seen& b) { return a.from->size() > b.from->size(); });
    const double near = std::sqrt(kChance * area / (M_PI * static_cast<double>(all.size())));
    std::vector<Seen> things;
    for (const Seen& seen : all) {
      std::vector<const std::set<std::size_t>*> there = {seen.from};
      for (const Seen& other : things) {
        const Eigen::Vector3d apart = seen.landmark->position - other.landmark->position;
        if (apart.norm() < near) there.push_back(other.from);
      }
      if (there.size() > 1 && !were_seen_together(there, usual)) {
        ++copies;
      } else {
        things.push_back(seen);
      }
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

/// What the keyframes saw, with the numbers of landmarks as ids, along the estimated path.
std::vector<MovedSightings> frames_of(const RunFacts& facts) {
  std::map<std::size_t, MovedSightings> frames;
  for (const FactOfSighting& s : facts.sightings) {
    MovedSightings& frame = frames[s.pose];
    frame.sightings.seen.push_back({Eigen::Vector2d(s.range, s.yaw), Eigen::Matrix2d::Zero()});
    frame.ids.emplace_back(s.landmark);
  }
  std::vector<MovedSightings> out;
  for (auto& [pose, frame] : frames) {
    if (pose >= facts.run.result.trajectory.size()) continue;
    frame.sightings.time = facts.run.result.trajectory[pose].time;
    const Eigen::Isometry3d T = facts.pose(pose);
    frame.T_odometry_robot = SE3(T.translation(), Eigen::Quaterniond(T.rotation()));
    out.push_back(std::move(frame));
  }
  return out;
}

/// Ids that never return tell nothing but what odometry does, and no other check sees anything.
void check_ids(const RunFacts& facts, Health& health) {
  const IdReturns returns = count_id_returns(frames_of(facts));
  const std::optional<double> share = returns.share();
  if (!share) return;
  HealthEntry entry;
  entry.name = "ids seen again";
  entry.value = *share;
  entry.least = IdReturns::kLeastReturning;
  entry.most = 1;
  if (returns.are_of_a_tracker()) entry.verdict = HealthVerdict::kBad;
  entry.sentence = fmt::format(
      "Of {} ids, {} were seen at more than one keyframe; places of {} came into view again, and "
      "{} "
      "were seen again.",
      returns.ids, returns.again, returns.due, returns.returned);
  if (entry.verdict == HealthVerdict::kBad) {
    entry.knob =
        "what the ids are: numbers of rows or of a tracker name no things ([sensor] ids = none "
        "hides them)";
  }
  health.push_back(std::move(entry));
}

}  // namespace

void check_landmarks(const RunFacts& facts, Health& health) {
  if (!facts.run.associates()) check_ids(facts, health);
  const auto& landmarks = facts.run.result.landmarks;
  if (landmarks.size() < kFewestLandmarks || facts.sightings.empty()) return;
  const std::vector<Looks> looks = looks_at(facts, view_of(facts.sightings));
  const std::optional<double> usual = usual_share(looks);
  if (facts.run.associates()) {
    const std::size_t copies = count_copies(facts, usual.value_or(kSeenDoubtful));
    health.push_back(entry_on_copies(copies, landmarks.size()));
  }
  // Directions become detections now and then: what a keyframe does not show was not missed.
  if (!usual || facts.run.statistics.count("directions") != 0) return;
  health.push_back(entry_on_looks(*usual));
  health.push_back(entry_on_lost(looks, *usual));
}

}  // namespace hybrid
