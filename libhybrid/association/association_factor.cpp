// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/association_factor.h"

#include <algorithm>
#include <utility>

namespace hybrid {
namespace {

template <class T>
std::size_t index_of(const std::vector<T>& in, const T& item) {
  return static_cast<std::size_t>(std::find(in.begin(), in.end(), item) - in.begin());
}

std::vector<Key> keys_of(const std::vector<AssociationOption>& options) {
  std::vector<Key> keys;
  for (const AssociationOption& option : options) {
    if (!option.factor) continue;
    for (const Key key : option.factor->keys()) {
      if (index_of(keys, key) == keys.size()) keys.push_back(key);
    }
  }
  return keys;
}

std::vector<VariableType> types_of(const std::vector<AssociationOption>& options) {
  const std::vector<Key> keys = keys_of(options);
  std::vector<VariableType> types(keys.size());
  for (const AssociationOption& option : options) {
    if (!option.factor) continue;
    for (std::size_t i = 0; i < option.factor->keys().size(); ++i) {
      types[index_of(keys, option.factor->keys()[i])] = option.factor->types()[i];
    }
  }
  return types;
}

std::vector<DiscreteKey> discrete_keys_of(DiscreteKey choice,
                                          const std::vector<AssociationOption>& options) {
  std::vector<DiscreteKey> keys = {choice};
  for (const AssociationOption& option : options) {
    if (!option.classes) continue;
    if (option.classes->keys().size() != 1) {
      throw Error("an option of " + to_string(choice.key) + " weighs more than one class variable");
    }
    const DiscreteKey key = option.classes->keys().front();
    if (index_of(keys, key) == keys.size()) keys.push_back(key);
  }
  return keys;
}

}  // namespace

AssociationFactor::AssociationFactor(DiscreteKey choice, std::vector<AssociationOption> options)
    : HybridFactor(keys_of(options), types_of(options), discrete_keys_of(choice, options)),
      options_(std::move(options)) {
  if (static_cast<int>(options_.size()) != choice.cardinality) {
    throw Error("an association over " + std::to_string(choice.cardinality) + " values of " +
                to_string(choice.key) + " has " + std::to_string(options_.size()) + " options");
  }
  positions_.resize(options_.size());
  for (std::size_t h = 0; h < options_.size(); ++h) {
    if (!options_[h].factor) continue;
    for (const Key key : options_[h].factor->keys()) {
      positions_[h].push_back(static_cast<int>(index_of(keys(), key)));
    }
  }
  for (std::size_t k = 1; k < discrete_keys().size(); ++k) {
    const DiscreteKey key = discrete_keys()[k];
    std::vector<double> costs(options_.size() * static_cast<std::size_t>(key.cardinality), 0.0);
    for (std::size_t h = 0; h < options_.size(); ++h) {
      if (!options_[h].classes || options_[h].classes->keys().front() != key) continue;
      std::copy(options_[h].classes->costs().begin(), options_[h].classes->costs().end(),
                costs.begin() + static_cast<std::ptrdiff_t>(h * key.cardinality));
    }
    class_tables_.emplace_back(std::vector<DiscreteKey>{choice, key}, std::move(costs));
  }
}

Component AssociationFactor::given(const Assignment& assignment) const {
  const int h = assignment.at(choice().key);
  const AssociationOption& option = options_[h];
  const double weight = option.classes ? option.classes->cost(assignment) : 0.0;
  return {option.factor.get(), positions_[h].data(), option.constant + weight, false, h};
}

std::vector<Table> AssociationFactor::given(const double* const* x) const {
  std::vector<double> costs;
  for (std::size_t h = 0; h < options_.size(); ++h) {
    const AssociationOption& option = options_[h];
    costs.push_back(component_cost(
        {option.factor.get(), positions_[h].data(), option.constant, false, static_cast<int>(h)},
        x));
  }
  std::vector<Table> tables = class_tables_;
  tables.emplace_back(std::vector<DiscreteKey>{choice()}, std::move(costs));
  return tables;
}

}  // namespace hybrid
