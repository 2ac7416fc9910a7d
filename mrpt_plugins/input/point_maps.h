// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/io/read_points.h"

namespace HYBRID_API hybrid {

/// Points from any file that a registration may be given: those of `read_points`; a serialised MRPT
/// points map or map of observations (of which the first is taken); or a rawlog, of which
/// `LOG.rawlog#N` names step N, counted from 0 (by default 0), seen from the robot. Throws Error
/// naming the file and what is wrong.
PointFile read_point_source(const std::string& path);

}  // namespace hybrid
