// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/detail/event_lines.h"

#include <nlohmann/json.hpp>

#include "libhybrid/core/key.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "mrpt_plugins/report/columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

void add_measurement(const SightingEvent& event, Json& out) {
  const Detection& d = event.detection;
  if (event.sensor->has_range) out["range"] = d.range;
  out["yaw"] = d.yaw;
  if (event.sensor->is_3d) out["pitch"] = d.pitch;
  if (d.id) out["id"] = *d.id;
  if (d.true_id && d.true_id != d.id) out["true_id"] = *d.true_id;
  if (!d.members.empty()) out["detections"] = d.members.size();
  if (d.moving) out["moving"] = true;
  for (std::size_t c = 0; c < d.class_probabilities.size(); ++c) {
    out["scores"][event.sensor->class_names.at(c)] = d.class_probabilities[c];
  }
}

/// [x, y, yaw], in space [x, y, z, yaw, pitch, roll].
Json pose_json(const mrpt::poses::CPose3D& pose, bool is_3d) {
  if (!is_3d) return {pose.x(), pose.y(), pose.yaw()};
  return {pose.x(), pose.y(), pose.z(), pose.yaw(), pose.pitch(), pose.roll()};
}

}  // namespace

Json sighting_line(std::size_t number, const RunRecord::Sighting& sighting) {
  const SightingEvent& event = sighting.event;
  Json out = {{"event", "sighting"}, {"keyframe", sighting.keyframe}, {"sighting", number}};
  out["sensor"] = event.sensor->sensor_label;
  add_measurement(event, out);
  out["landmark"] = or_null(event.landmark);
  if (event.nis) out["nis"] = *event.nis;
  for (const SightingCandidate& c : event.candidates) {
    out["candidates"].push_back({{"landmark", c.landmark},
                                 {"nis", c.nis},
                                 {"log_odds", c.log_odds},
                                 {"class_log_odds", c.class_log_odds}});
  }
  return out;
}

Json association_line(int keyframe, const AssociationEvent& event) {
  Json out = {{"event", "association"}, {"keyframe", keyframe}, {"sightings", event.sightings}};
  out["open"] = event.open;
  for (const AssociationEvent::Hypothesis& hypothesis : event.hypotheses) {
    Json landmarks = Json::array();
    for (const auto& id : hypothesis.landmarks) landmarks.push_back(or_null(id));
    out["hypotheses"].push_back({{"landmarks", landmarks}, {"log_odds", hypothesis.log_odds}});
  }
  return out;
}

Json decision_line(int keyframe, const DecisionEvent& event) {
  return {{"event", "decision"},
          {"keyframe", keyframe},
          {"sighting", event.sighting},
          {"landmark", or_null(event.landmark)},
          {"revised", event.revised}};
}

Json merge_line(int keyframe, const MergeEvent& event) {
  return {{"event", event.loop ? "loop" : "merge"},
          {"keyframe", keyframe},
          {"pairs", event.pairs},
          {"undone", event.undone},
          {"evidence", event.evidence},
          {"chi_square", event.chi_square},
          {"allowed_rise", event.allowed_rise()}};
}

Json change_line(const RunRecord::Change& change) {
  if (!change.refused.empty()) {
    return {{"event", "refusal"}, {"keyframe", change.keyframe}, {"reason", change.refused}};
  }
  Json flips = Json::array();
  for (const Flip& flip : change.flipped) {
    flips.push_back({{"variable", to_string(flip.key)},
                     {"from", flip.from},
                     {"to", flip.to},
                     {"half_step", flip.half_step}});
  }
  return {{"event", "change"},
          {"keyframe", change.keyframe},
          {"objectives", change.objectives},
          {"flips", flips}};
}

Json residual_line(std::size_t number, const RunRecord::Sighting& sighting) {
  Json out = {{"event", "residual"}, {"sighting", number}};
  out["landmark"] = or_null(sighting.landmark);
  const Eigen::VectorXd& r = sighting.residual;
  if (r.size() == 0) return out;
  out["residual"] = std::vector<double>(r.data(), r.data() + r.size());
  out["chi_square"] = sighting.chi_square;
  return out;
}

Json keyframe_json(const Mapper& mapper, const StepRecord& step) {
  const Key pose(key_letter::kPose, static_cast<std::uint64_t>(step.keyframe));
  Json out = {{"keyframe", step.keyframe}, {"time", step.time}};
  if (const auto robots = mapper.robot_names(); !robots.empty()) out["robot"] = robots[step.robot];
  out["pose"] = pose_json(pose_at(mapper.backend().values(), pose), mapper.is_3d());
  out["landmarks"] = step.landmarks;
  out["objective"] = step.objective_after;
  out["cost"] = step.cost;
  return out;
}

}  // namespace hybrid
