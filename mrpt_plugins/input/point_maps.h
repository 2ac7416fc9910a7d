// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/io/read_points.h"

namespace HYBRID_API hybrid {

/// Points from any input file of a registration: those of `read_points`; a serialised MRPT points
/// map, or the first one of a map of observations; or step N of a rawlog, given as `LOG.rawlog#N`,
/// counted from 0 (the default), in the frame of the robot. Throws Error naming the file and the
/// fault.
PointFile read_point_source(const std::string& path);

}  // namespace hybrid
