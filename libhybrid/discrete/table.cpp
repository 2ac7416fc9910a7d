// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/table.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

void check_probability(double p, DiscreteKey key) {
  if (!(p >= 0.0) || !std::isfinite(p)) {
    throw Error("probability of " + to_string(key.key) + " must be finite and not negative, got " +
                std::to_string(p));
  }
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

Table::Table(std::vector<DiscreteKey> keys, std::vector<double> costs)
    : keys_(std::move(keys)), costs_(std::move(costs)) {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (keys_[i].key == keys_[j].key) {
        throw Error("a table names discrete variable " + to_string(keys_[i].key) + " twice");
      }
    }
  }
  if (costs_.size() != joint_size(keys_)) {
    throw Error("a table over " + std::to_string(joint_size(keys_)) + " joint values has " +
                std::to_string(costs_.size()) + " costs");
  }
  for (double cost : costs_) {
    if (!(cost > -std::numeric_limits<double>::infinity())) {
      throw Error("a table" + (keys_.empty() ? "" : " over " + to_string(keys_[0].key)) +
                  " holds a cost that is not a number, or minus infinity");
    }
  }
}

std::size_t Table::index(const Assignment& assignment) const {
  return joint_index(keys_, assignment);
}

std::size_t joint_size(const std::vector<DiscreteKey>& keys) {
  std::size_t size = 1;
  for (const DiscreteKey& key : keys) {
    if (key.cardinality < 1) {
      throw Error("discrete variable " + to_string(key.key) + " has cardinality " +
                  std::to_string(key.cardinality));
    }
    if (size > std::numeric_limits<std::size_t>::max() / key.cardinality) {
      throw Error("too many joint values in a table that holds " + to_string(key.key));
    }
    size *= key.cardinality;
  }
  return size;
}

std::size_t joint_index(const std::vector<DiscreteKey>& keys, const Assignment& assignment) {
  std::size_t index = 0;
  for (const DiscreteKey& key : keys) {
    const int value = assignment.at(key.key);
    if (value < 0 || value >= key.cardinality) {
      throw Error("discrete variable " + to_string(key.key) + " cannot be " +
                  std::to_string(value));
    }
    index = index * key.cardinality + value;
  }
  return index;
}

void set_joint(const std::vector<DiscreteKey>& keys, std::size_t index, Assignment& assignment) {
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
    assignment.set(key->key, static_cast<int>(index % key->cardinality));
    index /= key->cardinality;
  }
}

std::string names_of(const std::vector<DiscreteKey>& keys) {
  std::string names;
  for (const DiscreteKey& key : keys) names += (names.empty() ? "" : ", ") + to_string(key.key);
  return names;
}

Table condition(const Table& table, const Assignment& held) {
  std::vector<DiscreteKey> keys;
  for (const DiscreteKey& key : table.keys()) {
    if (!held.contains(key.key)) keys.push_back(key);
  }
  if (keys.size() == table.keys().size()) return table;
  Assignment assignment;
  for (const DiscreteKey& key : table.keys()) {
    assignment.set(key.key, held.contains(key.key) ? held.at(key.key) : 0);
  }
  std::vector<double> costs;
  const std::size_t size = joint_size(keys);
  costs.reserve(size);
  for (std::size_t n = 0; n < size; ++n) {
    set_joint(keys, n, assignment);
    costs.push_back(table.cost(assignment));
  }
  return {std::move(keys), std::move(costs)};
}

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

Table prior_table(DiscreteKey key, const std::vector<double>& probabilities) {
  double sum = 0.0;
  for (double p : probabilities) {
    check_probability(p, key);
    sum += p;
  }
  if (!(sum > 0.0)) throw Error("probabilities of " + to_string(key.key) + " are all zero");
  std::vector<double> costs;
  costs.reserve(probabilities.size());
  for (double p : probabilities) costs.push_back(-std::log(p / sum));
  return {{key}, std::move(costs)};
}

Table transition_table(DiscreteKey from, DiscreteKey to, const std::vector<double>& probabilities) {
  return conditional_table(to, {from}, probabilities);
}

}  // namespace hybrid
