// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>

#include "libhybrid/factors/factor.h"
#include "libhybrid/hybrid/hybrid_factor.h"
#include "libhybrid/linear/charts.h"
#include "libhybrid/smoother/journaled_values.h"
#include "libhybrid/smoother/map_kind.h"

namespace hybrid {

/// What charts ask and tell about the variables of a map, by slot.
class MapVariables {
 public:
  virtual ~MapVariables() = default;
  /// Whether a motion of the map changes one of its factors.
  virtual bool is_held(int slot) const = 0;
  /// Called before its estimate changes.
  virtual void before_change(int slot) const = 0;
};

/// The charts of a map with poses of one kind, which move with the map as points of their dimension
/// do. `values` are the estimates; `estimate` is the same for changing them, null where nothing is
/// to be changed.
std::unique_ptr<Charts> make_charts(MapKind kind, const Values& values, JournaledValues* estimate,
                                    const MapVariables& variables);

/// The steps from the points of a chart to variables x, one after the other.
void steps_from(MapKind kind, Chart chart, const std::vector<VariableType>& types,
                const double* const* x, double* steps);

/// Whether a small motion of the map leaves a factor as it is, or all components of one, at x. None
/// does where the map has no poses (kVector).
bool moves_with_map(VariableKind pose, const ContinuousFactor& factor, const double* const* x);
bool moves_with_map(VariableKind pose, const HybridFactor& factor, const double* const* x);

}  // namespace hybrid
