// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A robust loss rho(s) of the squared whitened norm s = ||r||^2, with rho(s) ~ s near zero, so
/// that the cost of a factor is rho / 2. `parameter` is the usual tuning constant in whitened units
/// (sigmas).
struct Loss {
  enum class Kind { kNone, kHuber, kCauchy, kTukey, kGemanMcClure };

  Kind kind = Kind::kNone;
  double parameter = 1.0;

  static Loss none() { return {}; }
  static Loss huber(double k = 1.345) { return {Kind::kHuber, k}; }
  static Loss cauchy(double k = 2.385) { return {Kind::kCauchy, k}; }
  static Loss tukey(double k = 4.685) { return {Kind::kTukey, k}; }
  static Loss geman_mcclure(double k = 1.0) { return {Kind::kGemanMcClure, k}; }

  /// rho(s).
  double value(double s) const;
  /// rho'(s): the weight of iteratively reweighted least squares, in [0, 1].
  double weight(double s) const;
};

}  // namespace hybrid
