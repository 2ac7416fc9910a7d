// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/probabilities.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {

std::vector<double> to_probabilities(const Table& table) {
  std::vector<double> p = table.costs();
  const double least = *std::min_element(p.begin(), p.end());
  if (!std::isfinite(least)) {
    throw Error("a table over " + names_of(table.keys()) + " makes every joint value impossible");
  }
  double sum = 0.0;
  for (double& x : p) sum += x = to_potential(x - least);
  for (double& x : p) x /= sum;
  return p;
}

std::vector<double> posterior(std::vector<double> prior,
                              const std::vector<double>& log_likelihood) {
  if (prior.size() != log_likelihood.size()) {
    throw Error("a prior of " + std::to_string(prior.size()) + " values, likelihoods of " +
                std::to_string(log_likelihood.size()));
  }
  if (prior.empty()) return prior;
  const double top = *std::max_element(log_likelihood.begin(), log_likelihood.end());
  double sum = 0.0;
  for (std::size_t v = 0; v < prior.size(); ++v) {
    sum += prior[v] *= std::exp(log_likelihood[v] - top);
  }
  for (double& p : prior) p /= sum;
  return prior;
}

double class_cost(const std::vector<double>& likelihood, const std::vector<double>& belief) {
  if (likelihood.empty() || belief.size() != likelihood.size()) return 0.0;
  double p = 0.0;
  for (std::size_t s = 0; s < likelihood.size(); ++s) p += likelihood[s] * belief[s];
  return -std::log(p);
}

int most_probable(const std::vector<double>& probabilities) {
  if (probabilities.empty()) return -1;
  return static_cast<int>(std::max_element(probabilities.begin(), probabilities.end()) -
                          probabilities.begin());
}

}  // namespace hybrid
