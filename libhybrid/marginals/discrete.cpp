// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/discrete.h"

#include <utility>
#include <vector>

namespace hybrid {

DiscreteMarginals discrete_marginals(const HybridGraph& graph, const Values& values,
                                     const TableLimits& limits) {
  std::vector<Table> given;
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    for (Table& table : factor->given(values)) given.push_back(std::move(table));
  });
  std::vector<const Table*> tables;
  graph.discrete().for_each([&](Handle, const Table& table) { tables.push_back(&table); });
  for (const Table& table : given) tables.push_back(&table);
  return discrete_marginals(tables, limits);
}

}  // namespace hybrid
