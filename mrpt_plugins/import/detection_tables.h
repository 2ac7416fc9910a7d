// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detection_options.h"
#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// Converts the tables into a log with a step for each time of a detection or of a satellite fix;
/// the odometry between is interpolated. A detection's score is the probability of its class, the
/// rest is shared by the others; noted where classes are taken as certain. Detections and fixes
/// before the first or after the last pose are dropped.
ImportReport import_detection_tables(const DetectionTablesOptions& options,
                                     const std::string& output);

}  // namespace hybrid
