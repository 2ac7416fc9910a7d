// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/table.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "libhybrid/discrete/probabilities.h"

namespace hybrid {
namespace {

void check_probability(double p, DiscreteKey key) {
  if (!(p >= 0.0) || !std::isfinite(p)) {
    throw Error("probability of " + to_string(key.key) + " must be finite and not negative, got " +
                std::to_string(p));
  }
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
    std::size_t rest = n;
    for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
      assignment.set(key->key, static_cast<int>(rest % key->cardinality));
      rest /= key->cardinality;
    }
    costs.push_back(table.cost(assignment));
  }
  return {std::move(keys), std::move(costs)};
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
