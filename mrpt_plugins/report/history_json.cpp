// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/history_json.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "mrpt_plugins/report/columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnits = 65535;  // of a quantised coordinate, over the extent of the map

/// [landmark, NIS, log odds, log odds of the class] each.
Json candidates_json(const std::vector<SightingCandidate>& candidates) {
  Json out = Json::array();
  for (const SightingCandidate& c : candidates) {
    out.push_back({c.landmark, digits(c.nis), digits(c.log_odds), digits(c.class_log_odds)});
  }
  return out;
}

Json sightings_json(const RunRecord& record, bool is_3d) {
  Json out = empty_columns({"k", "sensor", "range", "yaw", "first", "now", "nis", "chi", "dr",
                            "dyaw", "id", "true", "moving", "scores", "candidates"});
  std::map<std::string, int> sensors;
  Json labels = Json::array(), classes = Json::array();
  for (const RunRecord::Sighting& s : record.sightings) {
    const Detection& d = s.event.detection;
    const auto [sensor, is_new] =
        sensors.emplace(s.event.sensor->sensor_label, static_cast<int>(sensors.size()));
    if (is_new) {
      labels.push_back(sensor->first);
      classes.push_back(s.event.sensor->class_names);
    }
    out["k"].push_back(s.keyframe);
    out["sensor"].push_back(sensor->second);
    out["range"].push_back(decimals(d.range, 3));
    out["yaw"].push_back(decimals(d.yaw, 4));
    if (is_3d) out["pitch"].push_back(decimals(d.pitch, 4));
    out["first"].push_back(or_null(s.event.landmark));
    out["now"].push_back(or_null(s.landmark));
    out["nis"].push_back(s.event.nis ? digits(*s.event.nis) : Json(nullptr));
    const bool known = s.residual.size() > 1;
    out["chi"].push_back(known ? digits(s.chi_square) : Json(nullptr));
    out["dr"].push_back(known ? decimals(s.residual[0], 3) : Json(nullptr));
    out["dyaw"].push_back(known ? decimals(s.residual[1], 4) : Json(nullptr));
    out["id"].push_back(or_null(d.id));
    out["true"].push_back(or_null(d.true_id));
    out["moving"].push_back(d.moving ? 1 : 0);
    out["scores"].push_back(digits(d.class_probabilities));
    out["candidates"].push_back(candidates_json(s.event.candidates));
  }
  out["sensors"] = std::move(labels);
  out["names"] = std::move(classes);
  return out;
}

/// Frames that could be seen in several ways.
Json associations_json(const RunRecord& record) {
  Json out = Json::array();
  for (const RunRecord::Association& a : record.associations) {
    if (a.event.hypotheses.size() < 2) continue;
    Json hypotheses = Json::array();
    for (const AssociationEvent::Hypothesis& h : a.event.hypotheses) {
      Json landmarks = Json::array();
      for (const auto& id : h.landmarks) landmarks.push_back(or_null(id));
      hypotheses.push_back({landmarks, digits(h.log_odds)});
    }
    out.push_back({{"k", a.keyframe},
                   {"sightings", a.event.sightings},
                   {"open", a.event.open},
                   {"hypotheses", hypotheses}});
  }
  return out;
}

Json merges_json(const RunRecord& record) {
  Json out = Json::array();
  for (const RunRecord::Merge& m : record.merges) {
    out.push_back({{"k", m.keyframe},
                   {"pairs", m.event.pairs},
                   {"loop", m.event.loop},
                   {"undone", m.event.undone},
                   {"evidence", digits(m.event.evidence)},
                   {"chi_square", digits(m.event.chi_square)},
                   {"allowed_rise", digits(m.event.allowed_rise())}});
  }
  return out;
}

/// Changes that solved something: keyframe, objectives after the half-steps, flips [variable, from,
/// to, half-step].
Json changes_json(const RunRecord& record) {
  Json out = empty_columns({"k", "objectives", "flips"});
  Json refusals = Json::array();
  for (const RunRecord::Change& change : record.changes) {
    if (!change.refused.empty()) refusals.push_back({change.keyframe, change.refused});
    if (change.objectives.empty()) continue;
    Json flips = Json::array();
    for (const Flip& flip : change.flipped) {
      flips.push_back({to_string(flip.key), flip.from, flip.to, flip.half_step});
    }
    out["k"].push_back(change.keyframe);
    out["objectives"].push_back(decimals(change.objectives, 3));
    out["flips"].push_back(std::move(flips));
  }
  out["refusals"] = std::move(refusals);
  return out;
}

Json beliefs_json(const RunRecord& record) {
  Json out = empty_columns({"k", "id", "p"});
  for (const RunRecord::Belief& belief : record.beliefs) {
    out["k"].push_back(belief.keyframe);
    out["id"].push_back(belief.landmark);
    out["p"].push_back(decimals(belief.probabilities));
  }
  return out;
}

/// Snapshots as whole numbers: a coordinate is origin + unit times the sum of the steps to it.
class SnapshotWriter {
 public:
  explicit SnapshotWriter(const std::vector<RunRecord::Snapshot>& snapshots, bool is_3d)
      : dimension_(is_3d ? 3 : 2) {
    Eigen::AlignedBox3d box;
    for (const RunRecord::Snapshot& s : snapshots) {
      for (const Eigen::Vector3d& p : s.path) box.extend(p);
      for (const auto& [id, p] : s.landmarks) box.extend(p);
    }
    if (box.isEmpty()) return;
    origin_ = box.min();
    unit_ = std::max(box.sizes().maxCoeff() / kUnits, 1e-9);
  }

  Json json(const RunRecord::Snapshot& s) const {
    std::vector<Eigen::Vector3d> places;
    std::vector<double> ids;
    for (const auto& [id, p] : s.landmarks) {
      ids.push_back(static_cast<double>(id));
      places.push_back(p);
    }
    return {{"k", s.keyframe},
            {"every", s.every},
            {"path", axes(s.path)},
            {"ids", steps_of(ids, 0, 1)},
            {"landmarks", axes(places)}};
  }

  Json origin() const { return std::vector<double>(origin_.data(), origin_.data() + dimension_); }
  double unit() const { return unit_; }

 private:
  Json axes(const std::vector<Eigen::Vector3d>& points) const {
    Json out = Json::array();
    for (int axis = 0; axis < dimension_; ++axis) {
      std::vector<double> column;
      for (const Eigen::Vector3d& p : points) column.push_back(p[axis]);
      out.push_back(steps_of(column, origin_[axis], unit_));
    }
    return out;
  }

  int dimension_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  double unit_ = 1;
};

Json snapshots_json(const RunRecord& record, bool is_3d) {
  const SnapshotWriter writer(record.snapshots, is_3d);
  Json list = Json::array();
  for (const RunRecord::Snapshot& s : record.snapshots) list.push_back(writer.json(s));
  return {{"origin", writer.origin()}, {"unit", writer.unit()}, {"list", list}};
}

}  // namespace

Json history_json(const RunRecord& record, bool is_3d) {
  Json decisions = Json::array(), lives = Json::array();
  for (const RunRecord::Decision& d : record.decisions) {
    decisions.push_back(
        {d.keyframe, d.event.sighting, or_null(d.event.landmark), d.event.revised ? 1 : 0});
  }
  for (const RunRecord::Life& life : record.lives) {
    lives.push_back({life.keyframe, life.landmark, life.born ? 1 : 0});
  }
  return {{"sightings", sightings_json(record, is_3d)},
          {"associations", associations_json(record)},
          {"decisions", decisions},
          {"merges", merges_json(record)},
          {"changes", changes_json(record)},
          {"beliefs", beliefs_json(record)},
          {"lives", lives},
          {"snapshots", snapshots_json(record, is_3d)}};
}

}  // namespace hybrid
