// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What an update must satisfy before anything is changed.
#include "libhybrid/smoother/detail/check.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

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

/// Cardinalities agree with what is known, or with other new factors; initial values are in range.
void check_discrete(const std::vector<DiscreteKey>& keys, const Delta& delta,
                    const DiscreteHalf& discrete, std::unordered_map<Key, int>& cardinality) {
  for (const DiscreteKey& key : keys) {
    const bool exists = discrete.contains(key.key);
    const int known = exists ? discrete.cardinality(key.key)
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
void check_removals(const Delta& delta, const HybridGraph& graph, const JournaledValues& values,
                    const Terms& terms) {
  std::vector<Handle> doomed;
  const auto is_doomed = [&](Handle handle) {
    return std::find(doomed.begin(), doomed.end(), handle) != doomed.end();
  };
  for (Handle handle : delta.remove) {
    if (!graph.contains(handle)) {
      throw Error("a factor to be removed is not, or no longer, in the graph");
    }
    if (is_doomed(handle)) throw Error("a factor is to be removed twice");
    doomed.push_back(handle);
  }
  std::unordered_set<Key> gone;
  for (Key key : delta.remove_values) {
    if (!gone.insert(key).second) {
      throw Error("variable " + to_string(key) + " is to be removed twice");
    }
    if (values.is_removed(key)) throw Error("variable " + to_string(key) + " has been removed");
    const std::vector<int>& own = terms.of_variable(values->slot(key));
    const auto stays = [&](int t) { return terms[t].alive && !is_doomed(terms[t].handle); };
    if (std::any_of(own.begin(), own.end(), stays)) {
      throw Error("variable " + to_string(key) + " cannot be removed: a factor still holds it");
    }
  }
}

}  // namespace

void check(const Delta& delta, const HybridGraph& graph, const JournaledValues& values,
           const Terms& terms, const DiscreteHalf& discrete) {
  for (Key key : delta.values.keys()) {
    if (values->contains(key)) throw Error("variable " + to_string(key) + " exists already");
  }
  const Lookup lookup(values, delta);
  for (const ContinuousFactorPtr& factor : delta.continuous) check_continuous(factor, lookup);
  std::unordered_map<Key, int> cardinality;
  for (const Table& table : delta.discrete) {
    check_discrete(table.keys(), delta, discrete, cardinality);
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    if (factor == nullptr) throw Error("a null factor was added");
    check_discrete(factor->discrete_keys(), delta, discrete, cardinality);
    check_hybrid(*factor, lookup);
  }
  check_removals(delta, graph, values, terms);
}

}  // namespace hybrid
