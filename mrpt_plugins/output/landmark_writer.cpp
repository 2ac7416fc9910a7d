// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/landmark_writer.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mrpt_plugins/output/detail/csv_field.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

void check_classes(const MapResult& result) {
  const std::size_t classes = result.class_names.size();
  for (const LandmarkEstimate& l : result.landmarks) {
    const bool index_fits = !l.class_index || (*l.class_index >= 0 &&
                                               static_cast<std::size_t>(*l.class_index) < classes);
    const std::size_t given = l.class_probabilities.size();
    if (!index_fits || (given != 0 && given != classes)) {
      throw std::invalid_argument(fmt::format(
          "landmark {}: class index {} and {} class probabilities do not fit {} class names", l.id,
          l.class_index.value_or(-1), given, classes));
    }
  }
}

Json landmark_json(const LandmarkEstimate& l, const std::vector<std::string>& class_names) {
  const int dimension = l.is_3d ? 3 : 2;
  Json position = Json::array();
  Json covariance = Json::array();
  for (int i = 0; i < dimension; ++i) {
    position.push_back(l.position[i]);
    Json row = Json::array();
    for (int j = 0; j < dimension; ++j) row.push_back(l.covariance(i, j));
    covariance.push_back(row);
  }
  Json out = {{"id", l.id}, {"position", position}, {"covariance", covariance}};
  out["class"] = l.class_index ? Json(class_names[*l.class_index]) : Json(nullptr);
  out["class_probabilities"] = Json::object();
  for (std::size_t c = 0; c < l.class_probabilities.size(); ++c) {
    out["class_probabilities"][class_names[c]] = l.class_probabilities[c];
  }
  out["sightings"] = l.sightings;
  out["extent_m"] = l.size.extent;
  out["things"] = l.size.things;
  return out;
}

}  // namespace

std::string landmarks_csv(const MapResult& result) {
  check_classes(result);
  std::string text =
      "id,x,y,z,cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,class,sightings,extent_m,things";
  for (const std::string& name : result.class_names) text += ',' + csv_field("p_" + name);
  text += '\n';
  for (const LandmarkEstimate& l : result.landmarks) {
    const auto& c = l.covariance;
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{},{},{},{},{},{},{}", l.id,
                   l.position.x(), l.position.y(), l.position.z(), c(0, 0), c(0, 1), c(0, 2),
                   c(1, 1), c(1, 2), c(2, 2),
                   l.class_index ? csv_field(result.class_names[*l.class_index]) : "", l.sightings,
                   l.size.extent, l.size.things);
    if (l.class_probabilities.empty()) text.append(result.class_names.size(), ',');
    for (const double p : l.class_probabilities) text += fmt::format(",{}", p);
    text += '\n';
  }
  return text;
}

std::string landmarks_json(const MapResult& result) {
  check_classes(result);
  Json out = {{"dimension", result.is_3d ? 3 : 2}, {"classes", result.class_names}};
  out["landmarks"] = Json::array();
  for (const LandmarkEstimate& l : result.landmarks) {
    out["landmarks"].push_back(landmark_json(l, result.class_names));
  }
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace hybrid
