// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/discrete/table.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A hybrid factor with its discrete variables fixed: -log f = factor + constant.
struct Component {
  /// Null if no continuous variable matters, e.g. for a constant null hypothesis.
  const ContinuousFactor* factor = nullptr;
  /// For each variable of `factor`, its index among the keys of the hybrid factor.
  const int* positions = nullptr;
  /// -log of the weight of the component; the log-normaliser is the factor's own.
  double constant = 0.0;
  /// True for a component with far less information than its siblings (an outlier model): solvers
  /// may omit its off-diagonal blocks, or all of it, from the matrix of a step to save fill-in. It
  /// remains in the objective, which decides about every step, and in covariances and evidence (eq.
  /// 13).
  bool weak = false;
  /// Identifies the component: when it changes, the linearisation of the factor is stale.
  int index = 0;
};

/// A factor over continuous and discrete variables, f_k(C_k, D_k) of eq. 3. The two `given` methods
/// are the two halves of alternating minimisation. Immutable.
class HybridFactor {
 public:
  virtual ~HybridFactor() = default;

  /// All continuous variables of any component, in the order in which `x` is given below.
  const std::vector<Key>& keys() const { return keys_; }
  const std::vector<VariableType>& types() const { return types_; }
  const std::vector<DiscreteKey>& discrete_keys() const { return discrete_keys_; }
  /// The discrete variables that choose the component. The others only weight it, so that their
  /// distribution does not depend on the covariance of the continuous variables.
  virtual std::vector<DiscreteKey> selectors() const { return discrete_keys_; }

  /// The continuous factor that remains when D is fixed (eq. 8b).
  virtual Component given(const Assignment& assignment) const = 0;

  /// The discrete factors that remain when C is fixed (eq. 8a): tables whose sum is -log f,
  /// log-normalisers included. x[i] points to the storage of variable i.
  virtual std::vector<Table> given(const double* const* x) const = 0;
  std::vector<Table> given(const Values& values) const;

  /// -log f at the given values of both kinds.
  double cost(const Values& values, const Assignment& assignment) const;

  /// Name for messages, e.g. "mixture".
  virtual std::string name() const = 0;

 protected:
  HybridFactor(std::vector<Key> keys, std::vector<VariableType> types,
               std::vector<DiscreteKey> discrete_keys);

 private:
  std::vector<Key> keys_;
  std::vector<VariableType> types_;
  std::vector<DiscreteKey> discrete_keys_;
};

using HybridFactorPtr = std::shared_ptr<const HybridFactor>;

/// -log of the density of a component at x, where x[i] is the storage of variable i of the hybrid
/// factor.
double component_cost(const Component& component, const double* const* x);

}  // namespace hybrid
