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

/// The registered plugins that suit a log, sorted by name. Plugins of libraries that the user loads
/// take precedence: a built-in plugin is left out if one of them uses a class of observations that
/// it uses too.
std::vector<std::string> choose_plugins(const LogContents& log);

/// Number and users of the observations of one class.
struct ObservationUse {
  std::size_t count = 0;           ///< observations
  std::vector<std::string> users;  ///< plugins, or "odometry"; may be empty
};

/// Uses of all classes of observations of a log by these plugins.
std::map<std::string, ObservationUse> observation_uses(
    const std::map<std::string, std::size_t>& observations,
    const std::vector<std::shared_ptr<MappingPlugin>>& plugins);

/// Message that says why these plugins mapped nothing, and what to do: by the kind of observation
/// that they use, and by what was `dropped` of it, with its reason.
std::string why_nothing_mapped(const std::map<std::string, ObservationUse>& uses,
                               const std::map<std::string, std::size_t>& dropped);

}  // namespace hybrid
