// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// The product of a continuous factor and a table over discrete variables, f(C, D) = psi(C) phi(D),
/// such as eq. 19. D weights the factor but does not change it, so its linearisation stays valid
/// when D changes.
class WeightedFactor : public HybridFactor {
 public:
  /// Throws Error for a null factor or a table over no variable.
  WeightedFactor(ContinuousFactorPtr factor, Table table);

  const ContinuousFactorPtr& factor() const { return factor_; }
  const Table& table() const { return table_; }

  Component given(const Assignment& assignment) const override;
  std::vector<Table> given(const double* const* x) const override;
  using HybridFactor::given;
  std::vector<DiscreteKey> selectors() const override { return {}; }
  std::string name() const override { return "weighted " + factor_->name(); }

 private:
  ContinuousFactorPtr factor_;
  Table table_;
  std::vector<int> positions_;
};

}  // namespace hybrid
