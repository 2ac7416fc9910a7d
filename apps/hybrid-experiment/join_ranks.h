// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>

#include "mrpt_plugins/experiment/ranks.h"

namespace hybrid {

/// The channel between the processes that mpirun or srun started; null if this process is the only
/// one. Its end waits for the others, unless this process was interrupted. Throws Error if several
/// processes were started that cannot find each other.
std::unique_ptr<Channel> join_ranks();

}  // namespace hybrid
