// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/landmark_metrics.h"

#include <algorithm>
#include <limits>
#include <map>
#include <tuple>

namespace hybrid {

LandmarkMatching match_by_id(const std::vector<LandmarkEstimate>& estimates,
                             const std::vector<TrueLandmark>& truth) {
  std::map<std::int64_t, std::size_t> free_truth;
  for (std::size_t t = 0; t < truth.size(); ++t) free_truth.emplace(truth[t].id, t);
  LandmarkMatching matching;
  for (std::size_t e = 0; e < estimates.size(); ++e) {
    const auto found = free_truth.find(estimates[e].id);
    if (found == free_truth.end()) continue;
    matching.emplace_back(e, found->second);
    free_truth.erase(found);
  }
  return matching;
}

LandmarkMatching match_by_distance(const std::vector<LandmarkEstimate>& estimates,
                                   const std::vector<TrueLandmark>& truth, double radius) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> candidates;
  for (std::size_t e = 0; e < estimates.size(); ++e) {
    for (std::size_t t = 0; t < truth.size(); ++t) {
      const double distance = (estimates[e].position - truth[t].position).norm();
      if (distance <= radius) candidates.emplace_back(distance, e, t);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> estimate_taken(estimates.size(), false);
  std::vector<bool> truth_taken(truth.size(), false);
  LandmarkMatching matching;
  for (const auto& [distance, e, t] : candidates) {
    if (estimate_taken[e] || truth_taken[t]) continue;
    estimate_taken[e] = truth_taken[t] = true;
    matching.emplace_back(e, t);
  }
  std::sort(matching.begin(), matching.end());
  return matching;
}

LandmarkErrors landmark_errors(const LandmarkMatching& matching,
                               const std::vector<LandmarkEstimate>& estimates,
                               const std::vector<TrueLandmark>& truth) {
  LandmarkErrors errors;
  errors.matched = matching.size();
  errors.spurious = estimates.size() - matching.size();
  errors.missed = truth.size() - matching.size();
  for (const auto& [e, t] : matching) {
    const double distance = (estimates[e].position - truth[t].position).norm();
    errors.mean_m += distance;
    errors.max_m = std::max(errors.max_m, distance);
  }
  if (matching.empty()) errors.max_m = std::numeric_limits<double>::quiet_NaN();
  errors.mean_m /= static_cast<double>(matching.size());
  return errors;
}

std::optional<double> class_accuracy(const LandmarkMatching& matching,
                                     const std::vector<LandmarkEstimate>& estimates,
                                     const std::vector<TrueLandmark>& truth) {
  std::size_t known = 0;
  std::size_t right = 0;
  for (const auto& [e, t] : matching) {
    if (!truth[t].class_index) continue;
    ++known;
    if (estimates[e].class_index == truth[t].class_index) ++right;
  }
  if (known == 0) return std::nullopt;
  return static_cast<double>(right) / static_cast<double>(known);
}

std::optional<double> association_accuracy(const std::vector<AssociationDecision>& decisions,
                                           const LandmarkMatching& matching,
                                           const std::vector<LandmarkEstimate>& estimates,
                                           const std::vector<TrueLandmark>& truth) {
  if (decisions.empty()) return std::nullopt;
  std::map<std::int64_t, std::int64_t> true_id;
  for (const auto& [e, t] : matching) true_id.emplace(estimates[e].id, truth[t].id);
  std::size_t right = 0;
  for (const AssociationDecision& d : decisions) {
    if (!d.estimated_id) {
      right += d.true_id ? 0 : 1;
      continue;
    }
    const auto found = true_id.find(*d.estimated_id);
    if (found != true_id.end() && d.true_id == found->second) ++right;
  }
  return static_cast<double>(right) / static_cast<double>(decisions.size());
}

}  // namespace hybrid
