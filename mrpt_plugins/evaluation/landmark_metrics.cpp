// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/landmark_metrics.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <map>
#include <set>
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

std::vector<std::pair<std::int64_t, std::int64_t>> exchanged_ids(
    const LandmarkMatching& matching, const std::vector<LandmarkEstimate>& estimates,
    const std::vector<TrueLandmark>& truth) {
  constexpr double kFar = 5;  // usual errors
  const auto distance = [&](std::size_t e, std::size_t t) {
    return (estimates[e].position - truth[t].position).norm();
  };
  std::vector<double> errors;
  for (const auto& [e, t] : matching) errors.push_back(distance(e, t));
  std::vector<std::pair<std::int64_t, std::int64_t>> out;
  if (errors.size() < 3) return out;
  std::vector<double> sorted = errors;
  std::sort(sorted.begin(), sorted.end());
  const double far = kFar * sorted[sorted.size() / 2];
  for (std::size_t a = 0; a < matching.size(); ++a) {
    for (std::size_t b = 0; b < a && errors[a] > far; ++b) {
      const auto [ea, ta] = matching[a];
      const auto [eb, tb] = matching[b];
      if (errors[b] > far && distance(ea, tb) < far && distance(eb, ta) < far) {
        out.emplace_back(truth[tb].id, truth[ta].id);
      }
    }
  }
  return out;
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
  std::size_t named = 0;
  std::size_t right = 0;
  for (const auto& [e, t] : matching) {
    if (!truth[t].class_index) continue;
    ++known;
    if (estimates[e].class_index) ++named;
    if (estimates[e].class_index == truth[t].class_index) ++right;
  }
  if (named == 0) return std::nullopt;
  return static_cast<double>(right) / static_cast<double>(known);
}

std::optional<double> landmark_nees(const LandmarkMatching& matching,
                                    const std::vector<LandmarkEstimate>& estimates,
                                    const std::vector<TrueLandmark>& truth) {
  double sum = 0;
  Eigen::Index freedoms = 0;
  for (const auto& [e, t] : matching) {
    const Eigen::Index n = estimates[e].is_3d ? 3 : 2;
    const Eigen::MatrixXd P = estimates[e].covariance.topLeftCorner(n, n);
    const Eigen::VectorXd error = (estimates[e].position - truth[t].position).head(n);
    const Eigen::LLT<Eigen::MatrixXd> llt(P);
    if (llt.info() != Eigen::Success) continue;
    sum += error.dot(llt.solve(error));
    freedoms += n;
  }
  if (freedoms == 0) return std::nullopt;
  return sum / static_cast<double>(freedoms);
}

AssociationReport association_report(const std::vector<AssociationDecision>& decisions) {
  AssociationReport report;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> votes;  // (estimated, true)
  for (const AssociationDecision& d : decisions) {
    if (!d.true_id) {
      ++report.unlabelled;
      if (!d.estimated_id) ++report.unlabelled_rejected;
    } else {
      ++report.labelled;
      if (d.estimated_id) {
        ++votes[{*d.estimated_id, *d.true_id}];
      } else {
        ++report.rejected;
      }
    }
  }
  std::vector<std::pair<std::size_t, std::pair<std::int64_t, std::int64_t>>> clearest;
  for (const auto& [pair, count] : votes) clearest.emplace_back(count, pair);
  std::stable_sort(clearest.begin(), clearest.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::set<std::int64_t> taken_estimates, taken_truths;
  for (const auto& [count, pair] : clearest) {
    if (taken_estimates.count(pair.first) != 0 || taken_truths.count(pair.second) != 0) continue;
    taken_estimates.insert(pair.first);
    taken_truths.insert(pair.second);
    report.right += count;
  }
  return report;
}

}  // namespace hybrid
