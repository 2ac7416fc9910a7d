// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/values.h"
#include "libhybrid/discrete/table.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/hybrid/handle.h"
#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// A discrete-continuous factor graph (eq. 2): three lists of factors by stable handle.
class HybridGraph {
 public:
  HybridGraph() = default;
  explicit HybridGraph(const std::vector<ContinuousFactorPtr>& factors) {
    for (const ContinuousFactorPtr& factor : factors) add(factor);
  }
  Handle add(ContinuousFactorPtr factor);
  Handle add(Table table);
  Handle add(HybridFactorPtr factor);
  /// A factor taken out of the graph; only the member of its kind is set.
  struct Removed {
    Handle handle;
    ContinuousFactorPtr continuous = nullptr;
    Table discrete = {};
    HybridFactorPtr hybrid = nullptr;
  };
  /// Throws Error for a handle that is not, or no longer, in the graph.
  Removed remove(Handle handle);
  /// Undoes a removal: the handle is valid again.
  void put_back(Removed removed);
  bool contains(Handle handle) const;

  /// Constructs a continuous factor of type T in place, e.g. graph.emplace<BetweenSE2>(a, b, z,
  /// noise).
  template <class T, class... Args>
  Handle emplace(Args&&... args) {
    return add(ContinuousFactorPtr(std::make_shared<T>(std::forward<Args>(args)...)));
  }

  const HandleList<ContinuousFactorPtr>& continuous() const { return continuous_; }
  const HandleList<Table>& discrete() const { return discrete_; }
  const HandleList<HybridFactorPtr>& hybrid() const { return hybrid_; }
  std::size_t size() const { return continuous_.size() + discrete_.size() + hybrid_.size(); }

  /// All discrete variables of any factor, in order of first appearance. Throws Error if two
  /// factors disagree about a cardinality.
  std::vector<DiscreteKey> discrete_keys() const;

 private:
  HandleList<ContinuousFactorPtr> continuous_{FactorKind::kContinuous};
  HandleList<Table> discrete_{FactorKind::kDiscrete};
  HandleList<HybridFactorPtr> hybrid_{FactorKind::kHybrid};
};

/// The joint negative log posterior L(C, D) of eq. 6, normalisers included.
double objective(const HybridGraph& graph, const Values& values, const Assignment& assignment);

/// Half the weighted squared error of the continuous factors and of the chosen components.
double cost(const HybridGraph& graph, const Values& values, const Assignment& assignment);

/// An estimate of all unknowns.
struct Estimate {
  Values values;
  Assignment assignment;
};

/// One atomic change of a graph, the contract between a sensor and a smoother.
struct Delta {
  std::vector<ContinuousFactorPtr> continuous;
  std::vector<Table> discrete;
  std::vector<HybridFactorPtr> hybrid;
  Values values;          ///< initial values of the new continuous variables
  Assignment assignment;  ///< initial values of new discrete variables; default 0
  std::vector<Handle> remove;
  std::vector<Key> remove_values;  ///< continuous variables to remove; no factor may use them
};

}  // namespace hybrid
