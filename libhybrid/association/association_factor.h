// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// What one detection is in one hypothesis about its frame: a sighting of a landmark, or none.
struct AssociationOption {
  ContinuousFactorPtr factor;  ///< psi(x, p) of eq. 19; null where no landmark of the map was seen
  double constant = 0.0;       ///< -log of the rest of the hypothesis
  std::optional<Table> classes;  ///< phi(s) of eq. 19, over the class of that landmark
};

/// One detection whose landmark is not decided (eq. 18, 19): option h counts where the variable
/// `choice`, which all detections of a frame share, has the value h. A value stands for a whole
/// matching of the frame, so that no landmark is seen twice in it. The tables are one over the
/// choice, and one over (choice, class) per landmark in question, however many landmarks those are.
class AssociationFactor : public HybridFactor {
 public:
  /// Throws Error unless there is one option per value of `choice` and each table of classes is
  /// over one variable.
  AssociationFactor(DiscreteKey choice, std::vector<AssociationOption> options);

  const std::vector<AssociationOption>& options() const { return options_; }

  Component given(const Assignment& assignment) const override;
  std::vector<Table> given(const double* const* x) const override;
  using HybridFactor::given;
  std::vector<DiscreteKey> selectors() const override { return {choice()}; }
  std::string name() const override { return "association"; }

 private:
  DiscreteKey choice() const { return discrete_keys().front(); }

  std::vector<AssociationOption> options_;
  std::vector<std::vector<int>> positions_;  // by option, see Component::positions
  std::vector<Table> class_tables_;          // over (choice, class), one per class variable
};

}  // namespace hybrid
