// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What an update must satisfy before anything is changed.
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

/// Looks variables up in a graph with a change on top.
class Lookup {
 public:
  Lookup(const JournaledValues& values, const Delta& delta) : values_(values), delta_(delta) {
    gone_.insert(delta.remove_values.begin(), delta.remove_values.end());
  }

  std::vector<const double*> gather(const std::string& name, const std::vector<Key>& keys,
                                    const std::vector<VariableType>& types) const {
    std::vector<const double*> x;
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const Values& home = delta_.values.contains(keys[i]) ? delta_.values : values_.get();
      if (!home.contains(keys[i]) || gone_.count(keys[i]) != 0 || values_.is_removed(keys[i])) {
        throw Error(describe(name, keys) + ": variable " + to_string(keys[i]) + " does not exist");
      }
      if (home.type(keys[i]) != types[i]) {
        throw Error(describe(name, keys) + ": variable " + to_string(keys[i]) + " is " +
                    to_string(home.type(keys[i])) + ", not " + to_string(types[i]));
      }
      x.push_back(home.data(keys[i]));
    }
    return x;
  }

 private:
  const JournaledValues& values_;
  const Delta& delta_;
  std::unordered_set<Key> gone_;
};

void check_continuous(const ContinuousFactorPtr& factor, const Lookup& lookup) {
  if (factor == nullptr) throw Error("a null factor was added");
  const auto x = lookup.gather(factor->name(), factor->keys(), factor->types());
  if (!std::isfinite(factor->cost(x.data()))) {
    throw Error(describe(factor->name(), factor->keys()) +
                " has a cost that is not finite; is its measurement?");
  }
}

void check_hybrid(const HybridFactor& factor, const Lookup& lookup) {
  const auto x = lookup.gather(factor.name(), factor.keys(), factor.types());
  for (const Table& table : factor.given(x.data())) {
    const auto& costs = table.costs();
    if (std::any_of(costs.begin(), costs.end(), [](double cost) { return std::isnan(cost); })) {
      throw Error(describe(factor.name(), factor.keys()) + " has a cost that is not a number");
    }
  }
}

}  // namespace

/// Throws Error for anything that would leave the graph inconsistent.
void IncrementalSmoother::check(const Delta& delta) const {
  for (Key key : delta.values.keys()) {
    if (values().contains(key)) throw Error("variable " + to_string(key) + " exists already");
  }
  const Lookup lookup(estimate_, delta);
  for (const ContinuousFactorPtr& factor : delta.continuous) check_continuous(factor, lookup);
  std::unordered_map<Key, int> cardinality;
  for (const Table& table : delta.discrete) check_discrete(table.keys(), delta, cardinality);
  for (const HybridFactorPtr& factor : delta.hybrid) {
    if (factor == nullptr) throw Error("a null factor was added");
    check_discrete(factor->discrete_keys(), delta, cardinality);
    check_hybrid(*factor, lookup);
  }
  check_removals(delta);
}

/// Cardinalities agree with what is known, or with other new factors; initial values are in range.
void IncrementalSmoother::check_discrete(const std::vector<DiscreteKey>& keys, const Delta& delta,
                                         std::unordered_map<Key, int>& cardinality) const {
  for (const DiscreteKey& key : keys) {
    const bool exists = discrete_.contains(key.key);
    const int known = exists ? discrete_.cardinality(key.key)
                             : cardinality.emplace(key.key, key.cardinality).first->second;
    if (known != key.cardinality) {
      throw Error("discrete variable " + to_string(key.key) + " has " + std::to_string(known) +
                  " values, but a new factor takes it to have " + std::to_string(key.cardinality));
    }
    if (exists || !delta.assignment.contains(key.key)) continue;
    const int value = delta.assignment.at(key.key);
    if (value < 0 || value >= key.cardinality) {
      throw Error("discrete variable " + to_string(key.key) + " cannot be " +
                  std::to_string(value));
    }
  }
}

/// What goes is there, goes once, and no factor is left without a variable.
void IncrementalSmoother::check_removals(const Delta& delta) const {
  std::unordered_set<int> doomed;
  std::vector<Handle> handles;
  for (Handle handle : delta.remove) {
    if (!graph_.contains(handle)) {
      throw Error("a factor to be removed is not, or no longer, in the graph");
    }
    if (std::find(handles.begin(), handles.end(), handle) != handles.end()) {
      throw Error("a factor is to be removed twice");
    }
    handles.push_back(handle);
    if (handle.kind != FactorKind::kDiscrete) doomed.insert(term_of(handle));
  }
  std::unordered_set<Key> gone;
  for (Key key : delta.remove_values) {
    if (!gone.insert(key).second) {
      throw Error("variable " + to_string(key) + " is to be removed twice");
    }
    if (estimate_.is_removed(key)) throw Error("variable " + to_string(key) + " has been removed");
    const std::vector<int>& terms = terms_.of_variable(values().slot(key));
    const auto stays = [&](int t) { return terms_[t].alive && doomed.count(t) == 0; };
    if (std::any_of(terms.begin(), terms.end(), stays)) {
      throw Error("variable " + to_string(key) + " cannot be removed: a factor still holds it");
    }
  }
}

}  // namespace hybrid
