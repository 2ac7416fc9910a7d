// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/hybrid_factor.h"

#include <array>
#include <utility>

namespace hybrid {

HybridFactor::HybridFactor(std::vector<Key> keys, std::vector<VariableType> types,
                           std::vector<DiscreteKey> discrete_keys)
    : keys_(std::move(keys)), types_(std::move(types)), discrete_keys_(std::move(discrete_keys)) {
  if (discrete_keys_.empty()) throw Error("a hybrid factor needs at least one discrete variable");
}

std::vector<Table> HybridFactor::given(const Values& values) const {
  return given(gather(keys_, types_, values).data());
}

double HybridFactor::cost(const Values& values, const Assignment& assignment) const {
  return component_cost(given(assignment), gather(keys_, types_, values).data());
}

double component_cost(const Component& component, const double* const* x) {
  if (component.factor == nullptr) return component.constant;
  const std::size_t n = component.factor->keys().size();
  std::array<const double*, 8> few;
  std::vector<const double*> many;
  if (n > few.size()) many.resize(n);
  const double** own = n > few.size() ? many.data() : few.data();
  for (std::size_t i = 0; i < n; ++i) own[i] = x[component.positions[i]];
  return component.constant + component.factor->log_normalizer() + component.factor->cost(own);
}

}  // namespace hybrid
