// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "libhybrid/detections/detection.h"

namespace HYBRID_API hybrid {

/// Finds detections that a log has more than once, as where messages or rows of a table are
/// doubled: of one sensor and time, the same to the bit. They are one measurement.
class RepeatedDetections {
 public:
  /// Leaves in a frame one of each, and none if the frame before of its sensor was of the same time
  /// and had the same detections. Returns how many are gone.
  std::size_t remove(DetectionFrame& frame);

 private:
  std::map<std::string, DetectionFrame> last_;  // by label
};

}  // namespace hybrid
