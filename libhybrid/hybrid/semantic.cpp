// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/semantic.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace hybrid {
namespace {

/// Throws Error unless all entries are finite and not negative with a positive sum.
void check_weights(const std::vector<double>& weights, const std::string& what) {
  double sum = 0.0;
  for (double w : weights) {
    if (!(w >= 0.0) || !std::isfinite(w)) {
      throw Error(what + " must be finite and not negative, got " + std::to_string(w));
    }
    sum += w;
  }
  if (!(sum > 0.0)) throw Error(what + " are all zero");
}

}  // namespace

Table likelihood_table(DiscreteKey class_key, const std::vector<double>& likelihood) {
  check_weights(likelihood, "class likelihoods of " + to_string(class_key.key));
  std::vector<double> costs;
  costs.reserve(likelihood.size());
  for (double p : likelihood) costs.push_back(-std::log(p));
  return {{class_key}, std::move(costs)};
}

std::vector<double> likelihood_of_detection(const Eigen::MatrixXd& confusion, int detected) {
  if (detected < 0 || detected >= confusion.cols()) {
    throw Error("detected class " + std::to_string(detected) + " is not one of the " +
                std::to_string(confusion.cols()) + " columns of the confusion matrix");
  }
  for (int s = 0; s < confusion.rows(); ++s) {
    const double sum = confusion.row(s).sum();
    if (!(std::abs(sum - 1.0) <= 1e-6) || confusion.row(s).minCoeff() < 0.0) {
      throw Error("row " + std::to_string(s) +
                  " of the confusion matrix must hold probabilities that sum to one, its sum is " +
                  std::to_string(sum));
    }
  }
  std::vector<double> likelihood(confusion.rows());
  Eigen::VectorXd::Map(likelihood.data(), confusion.rows()) = confusion.col(detected);
  return likelihood;
}

std::vector<double> likelihood_of_scores(const std::vector<double>& scores,
                                         const std::vector<double>& prior, double floor) {
  check_weights(scores, "class scores");
  if (!(floor >= 0.0)) throw Error("the floor of class scores must not be negative");
  if (!prior.empty()) {
    check_weights(prior, "class frequencies of the detector's training");
    if (prior.size() != scores.size()) {
      throw Error(std::to_string(scores.size()) + " class scores, but " +
                  std::to_string(prior.size()) + " class frequencies of the detector's training");
    }
  }
  std::vector<double> likelihood(scores.size());
  for (std::size_t s = 0; s < scores.size(); ++s) {
    const double frequency = prior.empty() ? 1.0 / static_cast<double>(scores.size()) : prior[s];
    if (!(frequency > 0.0)) {
      throw Error("class " + std::to_string(s) + " never occurred in the detector's training");
    }
    likelihood[s] = std::max(scores[s], floor) / frequency;
  }
  return likelihood;
}

}  // namespace hybrid
