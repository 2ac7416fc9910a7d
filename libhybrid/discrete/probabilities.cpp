// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/probabilities.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

std::string names_of(const std::vector<DiscreteKey>& keys) {
  std::string names;
  for (const DiscreteKey& key : keys) names += (names.empty() ? "" : ", ") + to_string(key.key);
  return names;
}

/// The values of the parents in one row, as text.
std::string row_name(const std::vector<DiscreteKey>& parents, std::size_t row) {
  std::string name;
  for (auto key = parents.rbegin(); key != parents.rend(); ++key) {
    const std::string value = std::to_string(row % key->cardinality);
    name = to_string(key->key) + " = " + value + (name.empty() ? "" : ", ") + name;
    row /= key->cardinality;
  }
  return name.empty() ? "of no parents" : "of " + name;
}

}  // namespace

double to_cost(double potential) {
  if (!(potential >= 0.0) || !std::isfinite(potential)) {
    throw Error("a probability must be finite and not negative, got " + std::to_string(potential));
  }
  return -std::log(potential);
}

double to_potential(double cost) {
  return std::exp(-cost);
}

Table potential_table(std::vector<DiscreteKey> keys, const std::vector<double>& potentials) {
  std::vector<double> costs;
  costs.reserve(potentials.size());
  try {
    for (double f : potentials) costs.push_back(to_cost(f));
  } catch (const Error& error) {
    throw Error("table over " + names_of(keys) + ", entry " + std::to_string(costs.size()) + ": " +
                error.what());
  }
  return {std::move(keys), std::move(costs)};
}

Table conditional_table(DiscreteKey child, const std::vector<DiscreteKey>& parents,
                        const std::vector<double>& probabilities) {
  const std::string name =
      "p(" + to_string(child.key) + (parents.empty() ? "" : " | " + names_of(parents)) + ")";
  std::vector<DiscreteKey> keys = parents;
  keys.push_back(child);
  const std::size_t size = joint_size(keys);
  if (probabilities.size() != size) {
    throw Error(name + " needs " + std::to_string(size) + " probabilities, got " +
                std::to_string(probabilities.size()));
  }
  const auto values = static_cast<std::size_t>(child.cardinality);
  for (std::size_t row = 0; row < size / values; ++row) {
    double sum = 0.0;
    for (std::size_t i = 0; i < values; ++i) {
      const double p = probabilities[row * values + i];
      if (!(p >= 0.0) || !std::isfinite(p)) {
        throw Error(name + ", row " + row_name(parents, row) +
                    ": a probability must be finite and not negative, got " + std::to_string(p));
      }
      sum += p;
    }
    if (std::abs(sum - 1.0) > 1e-6) {
      throw Error(name + ", row " + row_name(parents, row) + ": the probabilities sum to " +
                  std::to_string(sum) + "; make them sum to 1");
    }
  }
  return potential_table(std::move(keys), probabilities);
}

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
