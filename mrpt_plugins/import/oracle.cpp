// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/oracle.h"

#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace hybrid {
namespace {

struct Cluster {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t class_index = 0;
  std::vector<std::size_t> sightings;
};

}  // namespace

std::vector<std::int32_t> number_by_place(const std::vector<PlacedSighting>& sightings,
                                          double radius, std::size_t least) {
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    Cluster* nearest = nullptr;
    double distance = radius;
    for (Cluster& c : clusters) {
      if (c.class_index != sightings[i].class_index) continue;
      const Eigen::Vector3d mean = c.sum / static_cast<double>(c.sightings.size());
      const double d = (mean - sightings[i].place).norm();
      if (d >= distance) continue;
      distance = d;
      nearest = &c;
    }
    if (nearest == nullptr) {
      nearest = &clusters.emplace_back();
      nearest->class_index = sightings[i].class_index;
    }
    nearest->sum += sightings[i].place;
    nearest->sightings.push_back(i);
  }
  std::vector<std::int32_t> numbers(sightings.size(), mrpt::obs::INVALID_LANDMARK_ID);
  std::int32_t number = 0;
  for (const Cluster& c : clusters) {
    if (c.sightings.size() < least) continue;
    for (const std::size_t i : c.sightings) numbers[i] = number;
    ++number;
  }
  return numbers;
}

}  // namespace hybrid
