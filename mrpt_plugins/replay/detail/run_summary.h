// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mrpt_plugins/input/log_merge.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/summary.h"

namespace hybrid {

/// Adds warnings to a summary.
void warn(Summary& summary, const std::vector<std::string>& more);

/// What a finished run says, apart from truth, robots and files; `signal` is what stopped it, or 0.
Summary summarize(const LogMerge& source,
                  const std::vector<std::shared_ptr<MappingPlugin>>& plugins, const Mapper& mapper,
                  const BackendReport& last, const MapResult& result, int signal);

}  // namespace hybrid
