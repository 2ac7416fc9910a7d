// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/detail/run_facts.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/calibrated_bearing_range.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

template <class Pose>
Pose sensor_of(const BearingRange<Pose>& seen, const Values&) {
  return seen.T_robot_sensor();
}
template <class Pose>
Pose sensor_of(const CalibratedBearingRange<Pose>& seen, const Values& values) {
  return values.at<Pose>(seen.keys()[2]);
}

template <class Pose, template <class> class Factor>
bool add_sighting_of(const ContinuousFactor& factor, RunFacts& facts) {
  const auto* seen = dynamic_cast<const Factor<Pose>*>(&factor);
  if (seen == nullptr) return false;
  const typename Pose::Point p =
      sensor_of(*seen, facts.run.estimate.values) * from_polar(seen->measured());
  const FactOfSighting fact{factor.keys()[0].index(),
                            static_cast<std::int64_t>(factor.keys()[1].index()), p.norm(),
                            std::atan2(p[1], p[0])};
  facts.sightings.push_back(fact);
  facts.seen_from[fact.landmark].insert(fact.pose);
  return true;
}

bool leads_from_pose_to_pose(const ContinuousFactor& factor) {
  return factor.keys().size() >= 2 && factor.keys()[0].letter() == key_letter::kPose &&
         factor.keys()[1].letter() == key_letter::kPose;
}

/// A measured motion, that of odometry that is calibrated as its calibration has it.
std::optional<FactOfMotion> motion_of(const ContinuousFactor& factor, const Values& values) {
  const std::size_t to = factor.keys()[1].index();
  if (const auto* plane = dynamic_cast<const CalibratedMotion2*>(&factor)) {
    return FactOfMotion{to, to_isometry(plane->motion(values)),
                        planar_to_6d(noise_of(*plane).covariance())};
  }
  if (const auto* space = dynamic_cast<const CalibratedMotion3*>(&factor)) {
    return FactOfMotion{to, to_isometry(space->motion(values)), noise_of(*space).covariance()};
  }
  if (const auto plane = factor.relative_pose_2d()) {
    return FactOfMotion{to, to_isometry(plane->measured),
                        planar_to_6d(plane->information.inverse())};
  }
  if (const auto space = factor.relative_pose_3d()) {
    return FactOfMotion{to, to_isometry(space->measured), space->information.inverse()};
  }
  return std::nullopt;
}

void add_motion(const ContinuousFactor& factor, RunFacts& facts) {
  if (!leads_from_pose_to_pose(factor)) return;
  const std::size_t from = factor.keys()[0].index();
  const auto motion = motion_of(factor, facts.run.estimate.values);
  if (motion && motion->to > from) facts.motions.emplace(from, *motion);
}

void add_fact(const ContinuousFactor& factor, RunFacts& facts) {
  facts.factors.push_back(&factor);
  for (const Key key : factor.keys()) {
    if (key.letter() == key_letter::kPose) facts.in_graph.insert(key.index());
  }
  if (add_sighting_of<SE2, BearingRange>(factor, facts) ||
      add_sighting_of<SE3, BearingRange>(factor, facts) ||
      add_sighting_of<SE2, CalibratedBearingRange>(factor, facts) ||
      add_sighting_of<SE3, CalibratedBearingRange>(factor, facts)) {
    return;
  }
  add_motion(factor, facts);
}

}  // namespace

RunFacts::RunFacts(const RunToJudge& run) : run(run) {
  run.graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { add_fact(*factor, *this); });
  if (!run.result.has_odometry) motions.clear();
  run.graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(run.estimate.assignment);
    const auto& keys = factor->discrete_keys();
    const bool is_range = !keys.empty() && keys.front().key.letter() == key_letter::kRangeChoice;
    if (is_range) {
      ++ranges;
      if (component.factor == nullptr) ++false_ranges;
    }
    if (component.factor != nullptr) add_fact(*component.factor, *this);
  });
  for (const FactOfSighting& sighting : sightings) looked_from.insert(sighting.pose);
  const std::vector<StepRecord>& steps = run.result.steps;
  for (const std::size_t i : in_graph) {
    if (i >= steps.size() || steps[i].has_detections) looked_from.insert(i);
  }
  try {
    marginals.emplace(run.graph, run.estimate);
  } catch (const Error&) {
    // the checks that need covariances are left out
  }
}

Eigen::Isometry3d RunFacts::pose(std::size_t i) const {
  return isometry_at(run.estimate.values, Key(key_letter::kPose, i));
}

double RunFacts::figure(const char* name) const {
  const auto found = run.statistics.find(name);
  return found == run.statistics.end() ? 0 : found->second;
}

double factor_off(double scale) {
  constexpr double kMostFactor = 1000;
  return scale > 0 ? std::min(kMostFactor, std::max(scale, 1 / scale)) : kMostFactor;
}

Health run_health(const RunToJudge& run) {
  Health health;
  const RunFacts facts(run);
  check_landmarks(facts, health);
  check_detections(facts, health);
  check_scans(facts, health);
  check_clouds(facts, health);
  check_fixes(facts, health);
  check_path(facts, health);
  check_residuals(facts, health);
  return health;
}

}  // namespace hybrid
