// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Scores of a detector below this say no more.
inline constexpr double kLeastScore = 1e-6;

/// Adds `sign` times the log of the likelihood of each class, all positive, to `evidence`, which is
/// log p(detections of a thing | class). Detections without classes say nothing.
inline void add_class_likelihood(const std::vector<double>& likelihood, double sign,
                                 std::vector<double>& evidence) {
  if (likelihood.empty()) return;
  evidence.resize(likelihood.size());
  for (std::size_t s = 0; s < likelihood.size(); ++s) {
    evidence[s] += sign * std::log(likelihood[s]);
  }
}

/// The same of the scores of a detector, which may be zero.
inline void add_class_scores(std::vector<double> scores, std::vector<double>& evidence) {
  for (double& score : scores) score = std::max(score, kLeastScore);
  add_class_likelihood(scores, 1.0, evidence);
}

/// The class probabilities of a thing. The evidence of detections that have errors in common counts
/// as that of independent ones whose variance is by `inflation` larger.
inline std::vector<double> class_probabilities(std::vector<double> evidence, double inflation) {
  for (double& e : evidence) e /= inflation;
  return posterior(std::vector<double>(evidence.size(), 1.0), evidence);
}

/// -log of how well the scores of a detection go with those of a thing so far; 0 without classes in
/// common.
inline double class_disagreement(const std::vector<double>& scores,
                                 const std::vector<double>& evidence) {
  if (scores.empty() || scores.size() != evidence.size()) return 0;
  const std::vector<double> p = class_probabilities(evidence, 1.0);
  const double agree = std::inner_product(p.begin(), p.end(), scores.begin(), 0.0);
  return -std::log(std::max(agree, kLeastScore));
}

}  // namespace hybrid
