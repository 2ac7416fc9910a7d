// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/input/log_merge.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace hybrid {

/// The logs of all robots, not read yet.
LogMerge open_logs(const ReplaySettings& settings);

/// The mapper that they are for; plugins and back-end go over to it.
Mapper make_mapper(ReplaySettings& settings, bool is_3d);

}  // namespace hybrid
