// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/run_recorder.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "libhybrid/association/prediction.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/landmarks/sensor_place.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/report/detail/event_lines.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostSnapshots = 200;  // where there are more, every other one goes
constexpr int kMostPoses = 1000;             // in a snapshot

Key pose_key(int keyframe) {
  return {key_letter::kPose, static_cast<std::uint64_t>(keyframe)};
}

template <class Pose>
Eigen::VectorXd residual_of(const Pose& pose, const Pose& sensor, Key landmark,
                            const Eigen::VectorXd& z, const Values& values) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime, kAll = Pose::kDim + kDim;
  return predict_sightings<Pose>(pose, sensor, {values.at<typename Pose::Point>(landmark)},
                                 Eigen::MatrixXd::Zero(kAll, kAll))
      .innovation(z, 0);
}

}  // namespace

void RunRecorder::write(const Json& line) const {
  if (line_) line_(line);
}

void RunRecorder::begin(const std::string& version, const std::string& title, int dimension,
                        const std::vector<std::string>& robots) {
  Json line = {{"event", "run"},
               {"schema", 1},
               {"version", version},
               {"title", title},
               {"dimension", dimension}};
  if (!robots.empty()) line["robots"] = robots;
  write(line);
}

void RunRecorder::keyframe(Mapper& mapper, const StepRecord& step) {
  keyframe_ = step.keyframe;
  for (const MapChange& change : mapper.take_events()) add(change);
  write_class_names(mapper.class_names());
  update_beliefs();
  if (line_) {
    Json line = {{"event", "keyframe"}};
    line.update(keyframe_json(mapper, step));
    write(line);
  }
  record_.concluded = static_cast<int>(record_.changes.size());
  if (snapshots_ && keyframe_ % every_ == 0) add_snapshot(mapper, keyframe_);
}

void RunRecorder::add(const MapChange& change) {
  record_.changes.push_back({keyframe_, change.objectives, change.flipped, change.refused});
  if (line_) write(change_line(record_.changes.back()));
  const auto live = [&](const std::vector<std::int64_t>& ids, bool born) {
    for (const std::int64_t id : ids) {
      record_.lives.push_back({keyframe_, id, born});
      write({{"event", born ? "birth" : "removal"}, {"keyframe", keyframe_}, {"landmark", id}});
    }
  };
  live(change.born, true);
  if (!change.why.class_prior.empty()) class_prior_ = change.why.class_prior;
  for (const DecisionEvent& event : change.why.decisions) add(event);
  for (const SightingEvent& event : change.why.sightings) add(event);
  for (const AssociationEvent& event : change.why.associations) add(event);
  for (const MergeEvent& event : change.why.merges) add(event);
  live(change.forgotten, false);
  for (const std::int64_t id : change.forgotten) {
    for (const std::size_t s : std::vector<std::size_t>(seen_[id])) assign(s, std::nullopt);
  }
}

/// Sets the landmark that a sighting is assigned to from now on.
void RunRecorder::assign(std::size_t sighting, std::optional<std::int64_t> landmark) {
  std::optional<std::int64_t>& now = record_.sightings[sighting].landmark;
  add_class_evidence(record_.sightings[sighting], -1);
  if (now) {
    std::vector<std::size_t>& list = seen_[*now];
    list.erase(std::remove(list.begin(), list.end(), sighting), list.end());
  }
  now = landmark;
  if (!now) return;
  seen_[*now].push_back(sighting);
  add_class_evidence(record_.sightings[sighting], 1);
}

void RunRecorder::add(const SightingEvent& event) {
  const std::size_t s = record_.sightings.size();
  if (event.number >= 0) numbers_[event.number] = s;
  record_.sightings.push_back({keyframe_, event, std::nullopt, {}, 0});
  assign(s, event.landmark);
  if (line_) write(sighting_line(s, record_.sightings.back()));
}

void RunRecorder::add(const AssociationEvent& event) {
  RunRecord::Association own{keyframe_, event};
  for (std::int64_t& s : own.event.sightings) s = static_cast<std::int64_t>(number(s));
  if (line_) write(association_line(keyframe_, own.event));
  record_.associations.push_back(std::move(own));
}

void RunRecorder::add(const DecisionEvent& event) {
  RunRecord::Decision own{keyframe_, event};
  const std::size_t s = number(event.sighting);
  own.event.sighting = static_cast<std::int64_t>(s);
  assign(s, event.landmark);
  if (line_) write(decision_line(keyframe_, own.event));
  record_.decisions.push_back(own);
}

void RunRecorder::add(const MergeEvent& event) {
  for (const auto& [from, into] : event.pairs) {
    if (event.undone) break;
    const std::vector<std::size_t> moved = seen_[from];
    for (const std::size_t s : moved) assign(s, into);
  }
  if (line_) write(merge_line(keyframe_, event));
  record_.merges.push_back({keyframe_, event});
}

void RunRecorder::write_class_names(const std::vector<std::string>& names) {
  if (names == class_names_) return;
  class_names_ = names;
  write({{"event", "classes"}, {"names", names}});
}

/// Adds (sign 1) or removes (-1) the class evidence of a sighting at its landmark.
void RunRecorder::add_class_evidence(const RunRecord::Sighting& sighting, double sign) {
  const std::vector<double>& likelihood = sighting.event.class_likelihood;
  if (!sighting.landmark || likelihood.empty()) return;
  std::vector<double>& sum = class_evidence_[*sighting.landmark];
  sum.resize(likelihood.size(), 0.0);
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += sign * std::log(likelihood[c]);
  touched_.push_back(*sighting.landmark);
}

/// Class probabilities, given their sightings (eq. 19), of the landmarks whose sightings changed.
void RunRecorder::update_beliefs() {
  sort_unique(touched_);
  for (const std::int64_t id : touched_) {
    const std::vector<double>& evidence = class_evidence_[id];
    if (evidence.size() != class_prior_.size() || seen_[id].empty()) continue;
    add_belief(id, posterior(class_prior_, evidence));
  }
  touched_.clear();
}

void RunRecorder::add_belief(std::int64_t landmark, const std::vector<double>& probabilities) {
  if (probabilities.empty()) return;
  record_.beliefs.push_back({keyframe_, landmark, probabilities});
  write({{"event", "belief"},
         {"keyframe", keyframe_},
         {"landmark", landmark},
         {"probabilities", probabilities}});
}

void RunRecorder::finish(Mapper& mapper, const MapResult& result, double objective) {
  write({{"event", "conclusion"}});
  for (const MapChange& change : mapper.take_events()) add(change);
  touched_.clear();
  write_class_names(result.class_names);
  for (const LandmarkEstimate& l : result.landmarks) add_belief(l.id, l.class_probabilities);
  compute_residuals(mapper);
  if (snapshots_ && !result.trajectory.empty()) add_snapshot(mapper, keyframe_);
  write({{"event", "end"},
         {"keyframes", result.trajectory.size()},
         {"landmarks", result.landmarks.size()},
         {"objective", objective}});
}

/// The residuals of all sightings at the last estimate.
void RunRecorder::compute_residuals(const Mapper& mapper) {
  const Values& values = mapper.backend().values();
  for (std::size_t i = 0; i < record_.sightings.size(); ++i) {
    RunRecord::Sighting& s = record_.sightings[i];
    const Landmark* landmark = s.landmark ? mapper.landmarks().find(*s.landmark) : nullptr;
    const DetectionFrame& sensor = *s.event.sensor;
    if (landmark != nullptr && sensor.has_range) {
      const Eigen::Isometry3d T_robot_sensor = sensor_place(sensor, values);
      const Eigen::Isometry3d T_map_robot = isometry_at(values, s.event.pose);
      const Detection& d = s.event.detection;
      const Eigen::Vector3d z(d.range, d.yaw, d.pitch);
      s.residual = mapper.is_3d() ? residual_of(to_se3(T_map_robot), to_se3(T_robot_sensor),
                                                landmark->position, z, values)
                                  : residual_of(to_se2(T_map_robot), to_se2(T_robot_sensor),
                                                landmark->position, z.head(2), values);
      const Eigen::MatrixXd noise = measured_point(d, mapper.is_3d()).covariance;
      s.chi_square = gaussian_score(s.residual, noise).chi_square;
    }
    if (line_) write(residual_line(i, s));
  }
}

/// Keeps the present estimate; where there are too many snapshots, those at every other place stay.
void RunRecorder::add_snapshot(const Mapper& mapper, int keyframe) {
  std::vector<RunRecord::Snapshot>& all = record_.snapshots;
  if (!all.empty() && all.back().keyframe == keyframe) all.pop_back();
  if (all.size() >= kMostSnapshots) {
    every_ *= 2;
    const auto odd = [&](const auto& s) { return s.keyframe % every_ != 0; };
    all.erase(std::remove_if(all.begin(), all.end(), odd), all.end());
    if (keyframe % every_ != 0) return;
  }
  const Values& values = mapper.backend().values();
  RunRecord::Snapshot snapshot;
  snapshot.keyframe = keyframe;
  snapshot.every = 1 + keyframe / kMostPoses;
  for (int i = 0; i < keyframe; i += snapshot.every) {
    snapshot.path.push_back(isometry_at(values, pose_key(i)).translation());
  }
  snapshot.path.push_back(isometry_at(values, pose_key(keyframe)).translation());
  for (const auto& [id, landmark] : mapper.landmarks()) {
    snapshot.landmarks.emplace_back(id, point_at(values, landmark.position));
  }
  all.push_back(std::move(snapshot));
}

}  // namespace hybrid
