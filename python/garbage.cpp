// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "python/garbage.h"

#include "libhybrid/factors/inflated.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/hybrid/soft_mixture.h"
#include "libhybrid/hybrid/weighted.h"

namespace hybrid::python {
namespace {

int visit_components(const std::vector<MixtureComponent>& components, visitproc visit,
                     void* argument) {
  for (const MixtureComponent& component : components) {
    if (const int stop = visit_factor(component.factor, visit, argument)) return stop;
  }
  return 0;
}

}  // namespace

int visit_factor(const ContinuousFactorPtr& factor, visitproc visit, void* argument) {
  if (factor.use_count() != 1) return 0;  // null, or held by others too
  if (PyObject* object = python_object(factor)) return visit(object, argument);
  if (const auto* mixture = dynamic_cast<const SoftMixture*>(factor.get())) {
    return visit_components(mixture->components(), visit, argument);
  }
  if (const auto* inflated = dynamic_cast<const Inflated*>(factor.get())) {
    return visit_factor(inflated->factor(), visit, argument);
  }
  return 0;
}

int visit_factor(const HybridFactorPtr& factor, visitproc visit, void* argument) {
  if (factor.use_count() != 1) return 0;
  if (const auto* mixture = dynamic_cast<const Mixture*>(factor.get())) {
    return visit_components(mixture->components(), visit, argument);
  }
  if (const auto* weighted = dynamic_cast<const WeightedFactor*>(factor.get())) {
    return visit_factor(weighted->factor(), visit, argument);
  }
  return 0;
}

int visit_factors(const HybridGraph& graph, visitproc visit, void* argument) {
  int stop = 0;
  const auto each = [&](Handle, const auto& factor) {
    if (stop == 0) stop = visit_factor(factor, visit, argument);
  };
  graph.continuous().for_each(each);
  graph.hybrid().for_each(each);
  return stop;
}

}  // namespace hybrid::python
