// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/keyframe_lines.h"

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "libhybrid/core/spatial_values.h"
#include "mrpt_plugins/health/health_json.h"
#include "mrpt_plugins/report/detail/event_lines.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

/// Landmarks are told to the millimetre, so that not every line has all of them.
double to_millimetre(double metres) {
  return std::round(metres * 1e3) / 1e3;
}

Json landmark_json(const Landmark& landmark, const Mapper& mapper,
                   const std::vector<std::string>& class_names) {
  const Eigen::Vector3d p = point_at(mapper.backend().values(), landmark.position);
  Json out = {{"id", landmark.id}, {"position", {to_millimetre(p.x()), to_millimetre(p.y())}}};
  if (mapper.is_3d()) out["position"].push_back(to_millimetre(p.z()));
  const Assignment& assignment = mapper.backend().assignment();
  if (landmark.class_key && assignment.contains(landmark.class_key->key)) {
    const int index = assignment.at(landmark.class_key->key);
    out["class"] = class_names.at(static_cast<std::size_t>(index));
  }
  out["sightings"] = landmark.sightings;
  return out;
}

}  // namespace

std::string KeyframeLines::line(const Mapper& mapper, const StepRecord& step,
                                const std::optional<Health>& agreement) {
  Json changed = Json::array(), removed = Json::array();
  for (auto it = told_.begin(); it != told_.end();) {
    const bool is_there = mapper.landmarks().find(it->first) != nullptr;
    if (!is_there) removed.push_back(it->first);
    it = is_there ? std::next(it) : told_.erase(it);
  }
  const std::vector<std::string> class_names = mapper.class_names();
  for (const auto& [id, landmark] : mapper.landmarks()) {
    Json now = landmark_json(landmark, mapper, class_names);
    std::string text = now.dump(-1, ' ', false, Json::error_handler_t::replace);
    std::string& told = told_[id];
    if (told != text) changed.push_back(std::move(now));
    told = std::move(text);
  }
  Json out = keyframe_json(mapper, step);
  out["changed"] = std::move(changed);
  out["removed"] = std::move(removed);
  if (agreement) out["agreement"] = health_json(*agreement);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace hybrid
