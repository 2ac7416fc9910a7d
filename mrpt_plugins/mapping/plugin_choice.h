// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mrpt_plugins/input/log_contents.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// The registered plugins that suit a log, sorted by name. Those of libraries that a user loads go
/// first: a class of observations that one of them uses is left to it by the program's own.
std::vector<std::string> choose_plugins(const LogContents& log);

/// Who makes something of the observations of one class of a log.
struct ObservationUse {
  std::size_t count = 0;           ///< observations
  std::vector<std::string> users;  ///< plugins, or "odometry"; nobody: empty
};

/// The same for all classes of observations that a log holds, where these plugins map it.
std::map<std::string, ObservationUse> observation_uses(
    const std::map<std::string, std::size_t>& observations,
    const std::vector<std::shared_ptr<MappingPlugin>>& plugins);

/// Why these plugins found nothing to map, and what to do.
std::string why_nothing_mapped(const std::map<std::string, ObservationUse>& uses);

}  // namespace hybrid
