// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/error.h"
#include "libhybrid/landmarks/known_map.h"

namespace hybrid {

/// For plugins that know landmarks by the ids of a log: throws Error for a map whose ids are
/// numbers of the program that made it, since both are small numbers and would be mixed.
inline void refuse_numbered(const KnownMap& known) {
  if (known.identified) return;
  throw Error(
      "its landmarks are numbered by the program that made it, but those of the log have ids of "
      "their own; [sensor] ids = none (--set sensor.ids=none) finds them by their places");
}

}  // namespace hybrid
