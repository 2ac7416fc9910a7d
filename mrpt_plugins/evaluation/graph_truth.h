// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/core/values.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"

namespace HYBRID_API hybrid {

/// The true poses of a graph, in the frame of the file.
///
/// Without `times_file`, the file has all poses. It is a graph (poses by id, from its VERTEX lines
/// or its chained edges), a TUM file (.tum), or a table with rows `x y angle` or `x y z yaw pitch
/// roll` [m, rad], row i for poses[i].
///
/// With `times_file`, which has the time of each pose [s], the file has rows `time x y angle`.
/// Poses are interpolated between rows at most 2 s apart; poses outside of these are left out.
///
/// Throws Error for a missing or malformed file, or one that lacks poses.
std::map<Key, mrpt::poses::CPose3D> read_true_poses(const std::string& file,
                                                    const std::string& times_file,
                                                    const std::vector<Key>& poses);

/// Pairs the poses that have an estimate with the true ones, which are moved so that the first
/// poses coincide.
std::vector<PosePair> pair_with_truth(const std::map<Key, mrpt::poses::CPose3D>& truth,
                                      const Values& estimate);

}  // namespace hybrid
