// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/weighted.h"

#include <numeric>
#include <utility>

namespace hybrid {
namespace {

const ContinuousFactor& checked(const ContinuousFactorPtr& factor) {
  if (factor == nullptr) throw Error("a weighted factor needs a continuous factor, got null");
  return *factor;
}

}  // namespace

WeightedFactor::WeightedFactor(ContinuousFactorPtr factor, Table table)
    : HybridFactor(checked(factor).keys(), checked(factor).types(), table.keys()),
      factor_(std::move(factor)),
      table_(std::move(table)),
      positions_(keys().size()) {
  std::iota(positions_.begin(), positions_.end(), 0);
}

Component WeightedFactor::given(const Assignment& assignment) const {
  return {factor_.get(), positions_.data(), table_.cost(assignment)};
}

std::vector<Table> WeightedFactor::given(const double* const* x) const {
  const double psi = factor_->log_normalizer() + factor_->cost(x);
  std::vector<double> costs = table_.costs();
  for (double& cost : costs) cost += psi;
  std::vector<Table> tables;
  tables.emplace_back(table_.keys(), std::move(costs));
  return tables;
}

}  // namespace hybrid
