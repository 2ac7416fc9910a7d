// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/maps/CPointsMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/serialization/CSerializable.h>

#include <vector>

#include "mrpt_plugins/rawlog/log_object.h"

namespace hybrid {

/// What this program uses of an object of a rawlog. Of actions, the first CActionRobotMovement3D or
/// else 2D is the motion, whose particle and grid forms are taken by mean and covariance. Points
/// are told where they are asked for: of observations, of points maps and of CSimpleMap. Throws
/// Error for an object with nothing where something must be, and what MRPT throws.
LogObject convert_object(const mrpt::serialization::CSerializable::Ptr& object, bool points);

/// The keyframes of a simple map as a log has them: what each saw, and before that, but for the
/// first, the motion to it from the one before, whose errors are those of odometry.
std::vector<LogObject> keyframes_of(const mrpt::maps::CSimpleMap& map);

/// All points of a map, in its frame.
std::vector<mrpt::math::TPoint3Df> points_of(const mrpt::maps::CPointsMap& map);

}  // namespace hybrid
