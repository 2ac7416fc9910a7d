// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detection_options.h"
#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// Whether detections are boxes in images: a folder (YOLO), JSON (COCO results), or numbers without
/// names of columns, as det.txt of MOT has them.
bool are_image_boxes(const std::string& path);

/// Converts them.
ImportReport import_image_boxes(const DetectionTablesOptions& options, LogWriter& log);

}  // namespace hybrid
