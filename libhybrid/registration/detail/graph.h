// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/registration/target_cloud.h"

namespace hybrid {

/// The factor graph that `Alignment` solves, written out: T_target_source is x0, and d0, d1, ...
/// the counterpart of each source point, with target.size() for the outlier state. Each is a
/// mixture over all target points, so this is for small clouds; objective() of the graph is that of
/// the Alignment and one constant per source point, the log-normaliser of the noise.
HybridGraph registration_graph(const Points& source, const TargetCloud& target,
                               const MatchNoise& noise);

}  // namespace hybrid
