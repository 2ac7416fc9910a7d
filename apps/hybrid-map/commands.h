// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "apps/hybrid-map/options.h"
#include "libhybrid/maps/map_record.h"

namespace hybrid {

/// Each function runs a command, prints its report and returns the exit code. All throw Error.
int info(const Options& options);
int check(const Options& options);
int export_map(const Options& options);
int join(const Options& options);
int prune(const Options& options);

/// ", 4 local maps of laser scans", and of clouds; "" where a map has none.
std::string places_text(const MapRecord& map);

}  // namespace hybrid
