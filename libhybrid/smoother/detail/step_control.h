// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/smoother/continuous_half.h"

namespace hybrid {

/// The continuous half-step (eq. 9b): lowers the objective over the continuous variables by the
/// Gauss-Newton step of the tree; where it does not lower the objective as its linear model
/// promised, some more of them with all that moved linearised again; and where that does not help,
/// damped steps (Levenberg-Marquardt) from where the half-step began, over the variables that it
/// moved. A step that raises the objective is not taken where its linear model promises less than
/// linear models may be off by: what is left is rounding, which in a long chain no new
/// linearisation mends. Where it raises the objective by less than that, part of it is enough.
class StepControl {
 public:
  StepControl(ContinuousHalf& half, const Given& given, UpdateReport& report)
      : half_(half), given_(given), report_(report), before_(half.cost()) {}

  /// Leaves a status in the report where damped steps come to a singular system.
  void run();

 private:
  bool falls_short(double gained) const;
  void go_part_of_the_way(const Places& start);
  void fall_back();
  void damped_steps(const Places& start);

  ContinuousHalf& half_;
  const Given given_;
  UpdateReport& report_;
  const double before_;    // cost at the beginning
  double promised_ = 0.0;  // by the linear models of the first step
};

}  // namespace hybrid
