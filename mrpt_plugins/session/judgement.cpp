// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/judgement.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/health/agreement.h"
#include "mrpt_plugins/health/run_health.h"
#include "mrpt_plugins/session/detail/open_logs.h"

namespace hybrid {
namespace {

constexpr std::size_t kFewestCompared = 10;  // poses
constexpr double kAlike = 1.1;               // factor between badness of two maps that is by chance
constexpr double kMuchWorse = 1e9;
/// Two readings in one stamp are a doubled log; where half of all repeat, it is the clock.
constexpr UpperLimits kRepeatedLimits{0.1, 0.5};
constexpr UpperLimits kHalvesLimits{1.5, 2};  // sigmas are wrong by so much

/// The path of a map, and the tangent covariance of each pose.
struct HalfMap {
  Trajectory path;
  std::vector<Eigen::MatrixXd> covariances;
  bool is_3d = false;
};

/// Keeps every other one of the things that go past, of all together.
class EveryOther {
 public:
  explicit EveryOther(bool first) : keeps_(first) {}
  template <class Thing>
  void thin(std::vector<Thing>& things) {
    std::vector<Thing> kept;
    for (Thing& thing : things) {
      if (keeps_) kept.push_back(std::move(thing));
      keeps_ = !keeps_;
    }
    things = std::move(kept);
  }

 private:
  bool keeps_;
};

/// The map of half of the detections; observations that hold none are halved as they are.
HalfMap map_half(const ReplayRequest& request, const ReplaySettings& chosen, bool first) {
  const ReplayRequest own = with_chosen_plugins(request, chosen);
  const auto ini = open_config(own);
  ReplaySettings settings = read_settings(*ini, own);
  LogMerge source = open_logs(settings);
  Mapper mapper = make_mapper(settings, source.is_3d());
  EveryOther detections(first), observations(first);
  while (auto keyframe = source.next()) {
    throw_if_interrupted();
    for (DetectionFrame& frame : keyframe->detections) detections.thin(frame.detections);
    observations.thin(keyframe->observations);
    mapper.add(*keyframe);
  }
  mapper.finish();
  const MapResult result = mapper.result_without_sizes();
  return {result.trajectory, mapper.pose_covariances(), result.is_3d};
}

/// Squared sigmas of the difference of two poses, for each number; nothing where it is not known.
std::optional<double> difference(const HalfMap& a, std::size_t i, const HalfMap& b, std::size_t j) {
  const Eigen::MatrixXd &P = a.covariances[i], &Q = b.covariances[j];
  if (P.rows() == 0 || Q.rows() != P.rows()) return std::nullopt;
  const Eigen::Isometry3d D = to_isometry(a.path[i].pose).inverse() * to_isometry(b.path[j].pose);
  const Eigen::AngleAxisd turn(D.rotation());
  Eigen::Matrix<double, 6, 1> e;
  e << D.translation(), turn.angle() * turn.axis();
  Eigen::VectorXd own = e;
  if (!a.is_3d)
    own = Eigen::Vector3d(e[kPlanarIndices[0]], e[kPlanarIndices[1]], e[kPlanarIndices[2]]);
  const double squared = own.dot((P + Q).ldlt().solve(own)) / static_cast<double>(own.size());
  return std::isfinite(squared) ? std::optional(squared) : std::nullopt;
}

/// Both halves share the odometry, so that they differ by less than their covariances allow, and
/// more says that something is wrong.
Health compare_halves(const HalfMap& a, const HalfMap& b) {
  double sum = 0, apart = 0;
  std::size_t count = 0;
  for (std::size_t i = 1, j = 1; i < a.path.size() && j < b.path.size();) {
    const TimedPose &own = a.path[i], &other = b.path[j];
    if (own.time != other.time) {  // one of the two halves lacks a keyframe that was dropped
      ++(own.time < other.time ? i : j);
      continue;
    }
    if (const auto squared = difference(a, i++, b, j++)) {
      sum += *squared;
      apart = std::max(apart, own.pose.distanceTo(other.pose));
      ++count;
    }
  }
  if (count < kFewestCompared) return {};
  HealthEntry entry;
  entry.name = "halves of the detections";
  entry.value = std::sqrt(sum / static_cast<double>(count));
  entry.most = kHalvesLimits.doubtful;
  entry.verdict = judge(entry.value, kHalvesLimits);
  entry.sentence = fmt::format(
      "Every other detection mapped alone: the paths differ by up to {:.2g} m, {:.2g} times what "
      "their covariances allow.",
      apart, entry.value);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = "whatever the other checks name; where they are good, the noise of all detections";
  }
  return {entry};
}

/// How far the value of a check is from its limits, a factor; at most 1 within them.
double departure(const HealthEntry& entry) {
  if (entry.value < entry.least) return entry.value > 0 ? entry.least / entry.value : kMuchWorse;
  return entry.most > 0 ? entry.value / entry.most : kMuchWorse;
}

/// How far from its limits the value of a bad entry is; 0: it is not bad.
double badness(const HealthEntry& entry) {
  return entry.verdict == HealthVerdict::kBad ? departure(entry) : 0;
}

double worst_badness(const Health& health) {
  double worst = 0;
  for (const HealthEntry& entry : health) worst = std::max(worst, badness(entry));
  return worst;
}

/// What the stamps and the rests of the odometry say. A map whose places agree has not missed much
/// where it stood.
void check_odometry(const LogMerge& log, bool agrees, Health& health) {
  const double repeated_stamps = log.repeated_stamps();
  if (repeated_stamps > kRepeatedLimits.doubtful) {
    health.push_back(judged_entry(
        "stamps of the odometry that repeat", repeated_stamps, kRepeatedLimits,
        fmt::format("{:.0f} % of the stamps of the odometry are that of the one before, although "
                    "the robot moves: the clock is too coarse to tell when anything was seen.",
                    100 * repeated_stamps),
        "the clock that stamps the log"));
  }
  if (log.odometry_stops() == 0 || agrees) return;
  HealthEntry entry;
  entry.name = "odometry that stands";
  entry.value = static_cast<double>(log.odometry_stops());
  entry.verdict = HealthVerdict::kDoubtful;
  entry.sentence = fmt::format(
      "The odometry stands still {} times for more than a second, and stops and goes on faster "
      "than a robot brakes and starts.",
      log.odometry_stops());
  entry.knob = "whether the robot stood there, or the driver of its odometry had died";
  health.push_back(std::move(entry));
}

}  // namespace

std::ptrdiff_t count_judged(const Health& health) {
  return std::count_if(health.begin(), health.end(), [](const HealthEntry& entry) {
    return entry.verdict != HealthVerdict::kNotJudged && !entry.is_optional;
  });
}

bool is_better(const Health& a, const Health& b) {
  const HealthVerdict level = worst(b);
  const auto is_of_level = [level](const HealthEntry& entry) { return entry.verdict == level; };
  const bool is_worse = worst(a) > level || worst_badness(a) > kAlike * worst_badness(b);
  // A map of which less can be asked is not better for that.
  return !is_worse && count_judged(a) >= count_judged(b) &&
         std::count_if(a.begin(), a.end(), is_of_level) <
             std::count_if(b.begin(), b.end(), is_of_level);
}

Health judge_run(const ReplayRequest& request, const ReplaySettings& settings, const LogMerge& log,
                 const Mapper& mapper, const MapResult& result, Health agreement) {
  const Backend& backend = mapper.backend();
  const Estimate estimate{backend.values(), backend.assignment()};
  const std::map<std::string, std::size_t> dropped = mapper.dropped();
  const bool agrees = agreement_of(agreement) == HealthVerdict::kGood;
  Health health = std::move(agreement);
  for (HealthEntry& entry : run_health({backend.graph(), estimate, result, dropped,
                                        mapper.decisions().size(), mapper.statistics(), agrees})) {
    health.push_back(std::move(entry));
  }
  check_odometry(log, agrees, health);
  if (!request.cross_check) return health;
  for (const RobotSettings& robot : settings.robots) {
    if (is_standard_input(robot.rawlog)) {
      throw Error("--cross-check reads the log three times and needs a file");
    }
  }
  for (HealthEntry& entry :
       compare_halves(map_half(request, settings, true), map_half(request, settings, false))) {
    health.push_back(std::move(entry));
  }
  return health;
}

}  // namespace hybrid
