// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/map_record.h"

#include <memory>

#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/linear_factor.h"

namespace hybrid {

KnownMap known_map(const MapRecord& map) {
  KnownMap out;
  out.identified = map.identified;
  out.class_names = map.class_names;
  const int dim = map.dim();
  const Noise unit = Noise::unit(dim);
  for (const MapLandmark& landmark : map.landmarks) out.landmarks.push_back(landmark);
  for (const SparseRow& row : map.prior.rows) {
    std::vector<LinearFactor::Term> terms;
    Eigen::VectorXd b = Eigen::VectorXd::Zero(dim);
    for (std::size_t k = 0; k < row.variables.size(); ++k) {
      const MapLandmark& landmark = map.landmarks[static_cast<std::size_t>(row.variables[k])];
      const Eigen::MatrixXd A = row.R.middleCols(dim * static_cast<Eigen::Index>(k), dim);
      terms.push_back({position_key(landmark.id), A});
      b += A * landmark.position.head(dim);
    }
    out.prior.push_back(std::make_shared<LinearFactor>(terms, b, unit));
  }
  return out;
}

std::optional<MapOrigin> stated_origin(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  return MapOrigin{numbers.at(0), numbers.at(1), numbers.at(2), 0, false};
}

namespace {

std::optional<PlaceParent<SE2>>& parent_of(MapLocalMap& local) {
  return local.parent;
}

std::optional<PlaceParent<SE3>>& parent_of(MapLocalCloud& local) {
  return local.T_map_anchor.parent;
}

template <class Local>
void forget_of(std::vector<Local>& all, int session) {
  std::vector<Local> left;
  std::vector<std::optional<std::size_t>> number(all.size());  // by that before
  for (std::size_t m = 0; m < all.size(); ++m) {
    if (all[m].session == session) continue;
    number[m] = left.size();
    left.push_back(std::move(all[m]));
    auto& parent = parent_of(left.back());
    if (!parent) continue;
    if (number[parent->place]) {
      parent->place = *number[parent->place];
    } else {
      parent.reset();
    }
  }
  all = std::move(left);
}

}  // namespace

void forget_local_maps(MapRecord& map, int session) {
  forget_of(map.local_maps, session);
  forget_of(map.local_clouds, session);
}

}  // namespace hybrid
