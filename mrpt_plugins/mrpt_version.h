// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/version.h>

#include <algorithm>
#include <cstdint>
#include <limits>

#include "libhybrid/export.h"

// All that differs between MRPT 2.5 and MRPT 3 in what this project uses. The CMake variable
// HYBRID_MRPT chooses the version and with it the packages that are found.

/// RTTI of an abstract class.
#if MRPT_VERSION >= 0x20e00  // as of 2.14, that of Debian 13
#define HYBRID_DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace) \
  DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace)
#else
#define HYBRID_DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace) DEFINE_VIRTUAL_MRPT_OBJECT(Class)
#endif

#if MRPT_VERSION >= 0x30000

/// Overrides mrpt::obs::CObservation::getSensorPose() with a member or expression.
#define HYBRID_DEFINE_SENSOR_POSE(value)                \
  mrpt::poses::CPose3D getSensorPose() const override { \
    return value;                                       \
  }

namespace HYBRID_API hybrid {

/// Lets a map of points keep those that later scans see through, as MRPT 3 always does.
template <class InsertionOptions>
void keep_all_points(InsertionOptions&) {}

}  // namespace hybrid

#else

#define HYBRID_DEFINE_SENSOR_POSE(value)                          \
  void getSensorPose(mrpt::poses::CPose3D& pose) const override { \
    pose = value;                                                 \
  }

namespace HYBRID_API hybrid {

template <class InsertionOptions>
void keep_all_points(InsertionOptions& options) {
  options.disableDeletion = true;
}

}  // namespace hybrid

#endif

namespace HYBRID_API hybrid {

/// Seconds since 1970 of a time stamp, 0 if it is invalid: what mrpt::Clock::toDouble() of MRPT 2.5
/// returns. That of MRPT 3 rounds the time since 1601, whose ticks of 100 ns have more digits than
/// a double, by up to 0.8 microseconds.
inline double seconds_of(mrpt::Clock::time_point stamp) {
  if (stamp == mrpt::Clock::time_point()) return 0;
  constexpr std::int64_t kTicksPerSecond = 10'000'000;
  constexpr std::int64_t kFrom1601To1970 = 11'644'473'600 * kTicksPerSecond;
  const std::int64_t ticks = stamp.time_since_epoch().count();
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min() + kFrom1601To1970;
  return static_cast<double>(std::max(ticks, kLeast) - kFrom1601To1970) / kTicksPerSecond;
}

}  // namespace hybrid
