// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/detail/beacon_ranges.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/mixture.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BeaconRanges, hybrid)

namespace hybrid {
namespace {

using mrpt::obs::CObservationBeaconRanges;

ContinuousFactorPtr range_factor(Key pose, Key beacon, double range, double sigma,
                                 const Eigen::Vector3d& antenna, bool is_3d) {
  const Noise noise = Noise::isotropic(1, sigma);
  if (is_3d) {
    return std::make_shared<hybrid::Range<SE3, Eigen::Vector3d>>(pose, beacon, range, noise,
                                                                 antenna);
  }
  return std::make_shared<hybrid::Range<SE2, Eigen::Vector2d>>(pose, beacon, range, noise,
                                                               Eigen::Vector2d(antenna.head<2>()));
}

constexpr double kLeastSigma = 1e-6;    // of a range [m]
constexpr double kGreatestRange = 1e6;  // that can be meant [m]

/// False ranges are anything up to so many times the typical range, their geometric mean.
constexpr double kFalseReach = 4;

/// Why a range is unusable, or null. An antenna on the robot is nearer than `max_range`.
const char* fault(double range, const Eigen::Vector3d& antenna, double max_range) {
  if (!std::isfinite(range)) return "range dropped: not finite";
  if (!(antenna.norm() <= max_range)) return "range dropped: antenna not finite or too far";
  if (range <= 0) return "range dropped: not positive";
  return range > max_range ? "range dropped: above limit" : nullptr;
}

}  // namespace

void BeaconRanges::configure(IniSection section) {
  sensors_ = read_sensors(section);
  section.read("sigma", sigma_, "standard deviation of ranges [m]; 0: as the log says",
               or_zero(kSigmaMetres));
  section.read("sigma_factor", sigma_factor_, "factor of the standard deviations of the log",
               kPositive);
  section.read("max_range", max_range_, "longer ranges are dropped [m]; 0: none is", kLength);
  section.replaces("circle_hypotheses", "circle_places");
  section.replaces("sphere_hypotheses", "sphere_places");
  section.read("circle_hypotheses", circle_hypotheses_, "hypotheses on the circle of a first range",
               {4, 10000});
  section.read("sphere_hypotheses", sphere_hypotheses_, "and on the sphere, for a map in space",
               {8, 10000});
  section.read("delay", delay_,
               "keyframes that a range to an unknown beacon waits before it is used", {0, 10000});
  bank_ = read_bank_options(section);
}

Contribution BeaconRanges::observe(const Frame& frame, const MapView& map) {
  Contribution out;
  begin();
  for (const auto& observation : frame.observations) {
    const auto* seen = dynamic_cast<const CObservationBeaconRanges*>(observation.get());
    if (seen == nullptr) continue;
    if (is_wanted(seen->sensorLabel, sensors_)) take(*seen, frame, map, out);
  }
  const FrameValues values(frame.view(), map);
  for (const PlacedLandmark& landmark : unplaced_.place(frame.view(), map, bank_)) {
    place(landmark, values, map.is_3d, out);
  }
  // The range may be to a pending beacon that is about to be placed.
  if (!unplaced_.measured_lately(static_cast<std::size_t>(delay_))) {
    settle_ambiguous(values, map.is_3d, static_cast<std::size_t>(delay_), out);
  }
  ++frames_;
  measurements_ = 0;
  return out;
}

Contribution BeaconRanges::conclude(const MapView& map) {
  Contribution out;
  begin();
  settle_ambiguous(FrameValues(map), map.is_3d, 0, out);
  if (!ambiguous_.empty()) {
    out.dropped["range dropped: its beacon is not known, and none has a place"] +=
        ambiguous_.size();
    ambiguous_.clear();
  }
  if (std::exchange(concluded_, true)) return out;
  for (const auto& [why, count] : unplaced_.unplaced(bank_)) {
    out.dropped["range not used: its beacon has no place, since " + why] += count;
  }
  return out;
}

/// Beacons are known by the ids of a log: throws Error for a map of numbers, which are small, too.
void BeaconRanges::adopt(const KnownMap& known, bool) {
  if (known.identified) return;
  throw Error(
      "its landmarks are numbered by the program that made it, but beacons have ids of their own; "
      "map ranges in another file");
}

/// A new contribution.
void BeaconRanges::begin() {
  placed_.begin();
  known_before_ = known_;
  identified_before_ = identified_.size();
  taken_back_.clear();
}

void BeaconRanges::applied(const Outcome& outcome) {
  placed_.applied(outcome.handles);
  for (std::size_t i = identified_before_; i < identified_.size(); ++i) {
    identified_[i].factor = outcome.handles.hybrid[identified_[i].place];
  }
}

/// Forgets what the last contribution did; ranges to an unknown beacon that it had are lost.
void BeaconRanges::refused() {
  placed_.refused();
  known_ = known_before_;
  identified_.resize(identified_before_ - taken_back_.size());
  ambiguous_.erase(ambiguous_.begin(),
                   ambiguous_.begin() + static_cast<std::ptrdiff_t>(taken_back_.size()));
  identified_.insert(identified_.end(), taken_back_.begin(), taken_back_.end());
  std::sort(identified_.begin(), identified_.end(),
            [](const Choice& a, const Choice& b) { return a.key < b.key; });
}

Contribution BeaconRanges::revise(const MapView& map) {
  begin();
  const auto is_about = [](const Choice& choice, std::int64_t id) {
    return std::find(choice.beacons.begin(), choice.beacons.end(), id) != choice.beacons.end();
  };
  Contribution out = placed_.take_out(map, bank_, [&](std::int64_t id) {
    return std::all_of(identified_.begin(), identified_.end(), [&](const Choice& choice) {
      return !is_about(choice, id) || map.holds(choice.range.pose);
    });
  });
  for (const std::int64_t id : out.forgotten) {
    known_.erase(std::remove(known_.begin(), known_.end(), id), known_.end());
    const auto taken =
        std::stable_partition(identified_.begin(), identified_.end(),
                              [&](const Choice& choice) { return !is_about(choice, id); });
    taken_back_.insert(taken_back_.end(), taken, identified_.end());
    identified_.erase(taken, identified_.end());
  }
  std::sort(taken_back_.begin(), taken_back_.end(),
            [](const Choice& a, const Choice& b) { return b.key < a.key; });
  for (const Choice& choice : taken_back_) {
    out.delta.remove.push_back(choice.factor);
    ambiguous_.push_front(choice.range);
  }
  return out;
}

std::vector<AssociationDecision> BeaconRanges::decisions(const MapView& map) const {
  std::vector<AssociationDecision> out;
  const auto add = [&out](std::size_t pose, std::size_t measurement) -> AssociationDecision& {
    out.push_back({std::nullopt, std::nullopt, pose, measurement});
    return out.back();
  };
  for (const Choice& choice : identified_) {
    AssociationDecision& decision = add(choice.range.pose.index(), choice.range.measurement);
    const int value = map.assignment.find(choice.key);
    if (value >= 0 && value < static_cast<int>(choice.beacons.size())) {
      decision.estimated_id = choice.beacons[static_cast<std::size_t>(value)];
    }
  }
  for (const Range& range : ambiguous_) add(range.pose.index(), range.measurement);
  return out;
}

void BeaconRanges::take(const CObservationBeaconRanges& observation, const Frame& frame,
                        const MapView& map, Contribution& out) {
  const double logged = observation.stdError;
  const double sigma = sigma_ > 0 ? sigma_ : sigma_factor_ * logged;
  const double most = max_range_ > 0 ? max_range_ : kGreatestRange;
  if (!(sigma >= kLeastSigma && sigma <= most)) {
    out.dropped["range dropped: no sigma in the log that can be, nor in [BeaconRanges] sigma"] +=
        observation.sensedData.size();
    return;
  }
  for (const auto& m : observation.sensedData) {
    const auto& p = m.sensorLocationOnRobot;
    const Range range{frame.pose, m.sensedDistance, sigma, {p.x(), p.y(), p.z()},
                      frames_,    measurements_++};
    if (const char* reason = fault(range.range, range.antenna, most)) {
      ++out.dropped[reason];
      continue;
    }
    log_ranges_ += std::log(range.range);
    ++ranges_;
    if (m.beaconID < 0) {
      ambiguous_.push_back(range);
    } else if (map.landmarks.find(m.beaconID) != nullptr) {
      add_known(m.beaconID, measurement_of(m.beaconID, range, map.is_3d),
                FrameValues(frame.view(), map), out);
    } else {
      add_unplaced(m.beaconID, range, frame, map);
    }
  }
}

void BeaconRanges::add_unplaced(std::int64_t id, const Range& range, const Frame& frame,
                                const MapView& map) {
  const auto candidates = [&] {
    const Eigen::Vector3d a = transformed(frame.T_map_robot, range.antenna);
    if (map.is_3d) return ring_places(a, range.range, sphere_hypotheses_);
    return ring_places(Eigen::Vector2d(a.head<2>()), range.range, circle_hypotheses_);
  };
  unplaced_.add(id, measurement_of(id, range, map.is_3d), bank_, candidates);
  for (PlacedLandmarks::Measurement& old : placed_.restart(id)) {
    unplaced_.add(id, std::move(old), bank_, [] { return std::vector<Eigen::VectorXd>(); });
  }
}

PlacedLandmarks::Measurement BeaconRanges::measurement_of(std::int64_t id, const Range& range,
                                                          bool is_3d) const {
  const Key beacon = position_key(id);
  const double drifted = std::hypot(range.sigma, bank_.drift);
  return {range_factor(range.pose, beacon, range.range, drifted, range.antenna, is_3d),
          range_factor(range.pose, beacon, range.range, range.sigma, range.antenna, is_3d),
          1 / reach()};
}

/// Adds a range to a beacon that the sensor has named.
void BeaconRanges::add_known(std::int64_t id, const PlacedLandmarks::Measurement& measurement,
                             const FrameValues& values, Contribution& out) {
  const Key choice = add_choice({measurement.real}, values, out);
  placed_.measure(id, measurement, choice, out.delta.hybrid.size() - 1);
}

/// How long a false range may be [m].
double BeaconRanges::reach() const {
  return kFalseReach * std::exp(log_ranges_ / static_cast<double>(ranges_));
}

/// Adds a range as a mixture over beacons and a false range, whose density is uniform up to the
/// reach. Returns the discrete variable.
Key BeaconRanges::add_choice(const std::vector<ContinuousFactorPtr>& hypotheses,
                             const FrameValues& values, Contribution& out) {
  const DiscreteKey choice{Key(key_letter::kRangeChoice, choices_++),
                           static_cast<int>(hypotheses.size()) + 1};
  const double false_share = bank_.outlier_share;
  const double weight = -std::log((1 - false_share) / static_cast<double>(hypotheses.size()));
  std::vector<MixtureComponent> components;
  for (const ContinuousFactorPtr& factor : hypotheses) components.push_back({factor, weight});
  components.push_back({nullptr, -std::log(false_share / reach())});
  std::size_t best = hypotheses.size();
  double least = components.back().constant;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    const ContinuousFactor& factor = *hypotheses[i];
    const Key beacon = factor.keys()[1];
    const bool is_new = out.delta.values.contains(beacon);
    const double* const x[2] = {values(factor.keys()[0]),
                                is_new ? out.delta.values.data(beacon) : values(beacon)};
    const double cost = factor.cost(x) + factor.log_normalizer() + weight;
    if (cost >= least) continue;
    least = cost;
    best = i;
  }
  if (best < hypotheses.size()) {
    out.sighted.push_back(static_cast<std::int64_t>(hypotheses[best]->keys()[1].index()));
  }
  out.delta.assignment.set(choice.key, static_cast<int>(best));
  out.delta.hybrid.push_back(
      std::make_shared<Mixture>(std::vector<DiscreteKey>{choice}, std::move(components)));
  return choice.key;
}

void BeaconRanges::place(const PlacedLandmark& landmark, const FrameValues& values, bool is_3d,
                         Contribution& out) {
  insert_point(out.delta.values, position_key(landmark.id), padded_point(landmark.point), is_3d);
  out.landmarks.push_back({landmark.id, position_key(landmark.id), std::nullopt, 0});
  known_.push_back(landmark.id);
  placed_.place(landmark);
  for (const auto& measurement : landmark.measurements) {
    add_known(landmark.id, measurement, values, out);
  }
}

void BeaconRanges::settle_ambiguous(const FrameValues& values, bool is_3d, std::size_t delay,
                                    Contribution& out) {
  if (known_.empty()) return;
  while (!ambiguous_.empty() && frames_ >= ambiguous_.front().frame + delay) {
    const Range range = ambiguous_.front();
    ambiguous_.pop_front();
    std::vector<ContinuousFactorPtr> hypotheses;
    for (const std::int64_t id : known_) {
      hypotheses.push_back(range_factor(range.pose, position_key(id), range.range, range.sigma,
                                        range.antenna, is_3d));
    }
    const Key key = add_choice(hypotheses, values, out);
    identified_.push_back({range, key, known_, out.delta.hybrid.size() - 1});
  }
}

}  // namespace hybrid
