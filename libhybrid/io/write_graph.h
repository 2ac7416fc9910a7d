// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Writes a graph as g2o, with the fewest digits that read back as the same number, under a
/// temporary name that is renamed when complete. In g2o poses and landmarks share their ids: if a
/// landmark has the index of a pose, all landmarks get ids after the last pose (id = index +
/// largest pose index + 1). Throws Error if the file cannot be written, a vertex is neither a pose
/// nor a point, or a position in the plane has a lever arm, for which g2o has no form.
void write_g2o(const std::string& path, const PoseGraph& graph);

/// The text of a graph as g2o.
std::string to_g2o(const PoseGraph& graph);

}  // namespace hybrid
