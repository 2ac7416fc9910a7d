// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/jcbb.h"

#include <mrpt/slam/data_association.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/geometry/so2.h"

namespace hybrid {
namespace {

/// Half a turn away from the middle of the widest gap between some angles.
double best_zero(std::vector<double> angles) {
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2 * M_PI - angles.back();
  double middle = angles.back() + 0.5 * widest;
  for (std::size_t i = 1; i < angles.size(); ++i) {
    const double gap = angles[i] - angles[i - 1];
    if (gap <= widest) continue;
    widest = gap;
    middle = angles[i - 1] + 0.5 * gap;
  }
  return middle + M_PI;
}

}  // namespace

Matching joint_compatibility(const FrameCandidates& candidates, double gate) {
  const PredictedSightings& predicted = candidates.predicted;
  const int rows = static_cast<int>(candidates.measured.size());
  const int cols = static_cast<int>(candidates.tracks.size());
  Matching matching{std::vector<int>(rows, -1), 0};
  if (rows == 0 || cols == 0) return matching;
  const int dim = predicted.dim;
  std::vector<double> yaws;
  for (const MeasuredPoint& m : candidates.measured) yaws.push_back(wrap_angle(m.z[1]));
  for (int j = 0; j < cols; ++j) yaws.push_back(wrap_angle(predicted.mean(1, j)));
  const double zero = best_zero(yaws);

  mrpt::math::CMatrixDouble z(rows, dim), y(cols, dim);
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < dim; ++k) z(i, k) = candidates.measured[i].z[k];
    z(i, 1) = wrap_angle(z(i, 1) - zero);
  }
  std::vector<mrpt::slam::prediction_index_t> names;
  for (int j = 0; j < cols; ++j) {
    for (int k = 0; k < dim; ++k) y(j, k) = predicted.mean(k, j);
    y(j, 1) = wrap_angle(y(j, 1) - zero);
    names.push_back(static_cast<mrpt::slam::prediction_index_t>(j));
  }
  mrpt::math::CMatrixDouble S(dim * cols, dim * cols);
  S.asEigen() = predicted.covariance;
  for (int j = 0; j < cols; ++j) {
    S.asEigen().block(dim * j, dim * j, dim, dim) += candidates.measured.front().covariance;
  }
  mrpt::slam::TDataAssociationResults results;
  mrpt::slam::data_association_full_covariance(z, y, S, results, mrpt::slam::assocJCBB,
                                               mrpt::slam::metricMaha, gate, true, names);
  for (const auto& [i, j] : results.associations) {
    matching.column[static_cast<std::size_t>(i)] = static_cast<int>(j);
  }
  return matching;
}

}  // namespace hybrid
