// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationPointCloud.h>

#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A cloud of a log, of whatever class, whose points may have times. In memory only: MRPT knows it
/// as the class that it derives from, and writes no times of it.
class LoggedCloud : public mrpt::obs::CObservationPointCloud {
 public:
  /// When each point was seen, relative to the timestamp [s]; empty where that is not known.
  std::vector<float> times;
};

}  // namespace hybrid
