// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationPointCloud.h>

#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A cloud of a log, of whatever class, whose points may have times. In memory only: MRPT knows it
/// as the class that it derives from, and writes no times of it.
class LoggedCloud : public mrpt::obs::CObservationPointCloud {
 public:
  /// When each point was seen, relative to the timestamp [s]; empty where that is not known.
  std::vector<float> times;
  /// Where `pointcloud` is null, the file beside the log that has the points, as the log names it,
  /// and its form. Not by MRPT's own members, so that nothing of MRPT opens it.
  std::string file;
  ExternalStorageFormat form = ExternalStorageFormat::None;
  /// Why there are no points, where that is known.
  std::string fault;
};

}  // namespace hybrid
