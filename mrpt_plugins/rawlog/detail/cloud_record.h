// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/observations/logged_cloud.h"
#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {

/// Whether an observation is a cloud of points in space: a CObservationPointCloud, or that of a
/// depth camera (CObservation3DRangeScan) or of a lidar (CObservationVelodyneScan).
bool is_cloud_of_log(const mrpt::obs::CObservation& observation);

/// Writes its points, without intensities and colours, and the pose of its sensor; times of points
/// where a CObservationVelodyneScan has them, or packets that tell them, relative to its stamp
/// [s], NaN where one is not known. Of points that are kept in a file beside the log, which is not
/// read, the name of the file and its form are written. Throws Error for more than ten million
/// points or times.
void write_cloud(ByteWriter& out, const mrpt::obs::CObservation& observation);

/// Reads what write_cloud() wrote. The pointcloud is null where the points are in another file.
void read_cloud(ByteReader& in, LoggedCloud& cloud);

}  // namespace hybrid
