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

}  // namespace hybrid
