// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// A loop closure that a method judged.
struct JudgedClosure {
  bool accepted = false;
  bool checkable = false;  ///< whether other measurements check it
  double margin = 0;  ///< log odds of its decision against the other one; not finite: not known
};

/// What the closures of a graph say about the result: how many were rejected, and how narrowly the
/// narrowest decision was made.
Health closure_health(const std::vector<JudgedClosure>& closures);

}  // namespace hybrid
