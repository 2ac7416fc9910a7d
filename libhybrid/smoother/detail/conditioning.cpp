// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/conditioning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/discrete/inference.h"

namespace hybrid {

FixedVariables fix(const std::vector<Key>& discrete, const IncrementalSmoother& smoother) {
  FixedVariables fixed;
  for (Key key : discrete) fixed.values.set(key, smoother.assignment().at(key));
  for (Key key : discrete) {
    if (fixed.posterior.count(key) != 0) continue;
    const std::vector<const Table*> tables = smoother.component(key);
    const DiscreteMarginals marginals = discrete_marginals(tables);
    std::vector<Table> conditioned;
    for (const Table* table : tables) conditioned.push_back(condition(*table, fixed.values));
    std::vector<const Table*> rest;
    for (const Table& table : conditioned) rest.push_back(&table);
    fixed.divergence += marginals.log_partition() - discrete_marginals(rest).log_partition();
    for (Key own : discrete) {
      if (!marginals.contains(own)) continue;
      const auto p = marginals.at(own);
      const int value = fixed.values.at(own);
      std::vector<double> costs;
      for (double share : p) costs.push_back(std::log(p[value]) - std::log(share));
      fixed.posterior[own] = Table({{own, static_cast<int>(p.size())}}, std::move(costs));
    }
  }
  return fixed;
}

void condition_on(const FixedVariables& fixed, const std::vector<Handle>& breaks,
                  const IncrementalSmoother& smoother, const WindowTables& tables, Delta& change) {
  const HybridGraph& graph = smoother.graph();
  double constant = 0.0;
  for (Handle handle : breaks) {
    constant += handle.kind == FactorKind::kHybrid
                    ? graph.hybrid().at(handle)->cost(smoother.values(), smoother.assignment())
                    : graph.continuous().at(handle)->cost(smoother.values()) +
                          graph.continuous().at(handle)->log_normalizer();
  }
  for (const auto& [key, table] : fixed.posterior) {
    for (Handle handle : tables.holders(key)) {
      if (handle.kind != FactorKind::kDiscrete || !graph.contains(handle)) continue;
      const Table& tie = graph.discrete().at(handle);
      const bool counted =
          std::find(change.remove.begin(), change.remove.end(), handle) != change.remove.end();
      if (tie.keys().size() < 2 || counted) continue;
      change.remove.push_back(handle);
      Table left = condition(tie, fixed.values);
      if (left.keys().empty()) {
        constant += left.costs()[0];
      } else {
        change.discrete.push_back(std::move(left));
      }
    }
  }
  add_constant(constant, change);
}

}  // namespace hybrid
