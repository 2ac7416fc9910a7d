// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/rawlog/asked_classes.h"
#include "mrpt_plugins/rawlog/byte_io.h"
#include "mrpt_plugins/rawlog/log_object.h"

namespace HYBRID_API hybrid {

/// More detections or rays than this in one observation, or classes of a detector, are taken for
/// damage.
inline constexpr std::size_t kMaxDetections = 100'000;

/// Writes an observation: one of a class that is asked for as MRPT serialises it, of a class that
/// this program knows number by number (a scan without intensities, a satellite fix with its
/// messages GGA, RMC and BESTPOS), of any other only its class and time. Where
/// CObservationPointCloud is asked for, all clouds of lidars and depth cameras are given as such,
/// number by number. Throws Error for more than
/// kMaxDetections, and what MRPT throws.
void write_observation(ByteWriter& out, const LoggedObservation& observation,
                       const AskedClasses& asked);

/// Reads what write_observation() wrote; throws Error for anything else. MRPT's parsers see only
/// objects of classes that are asked for.
LoggedObservation read_observation(ByteReader& in, const AskedClasses& asked);

}  // namespace hybrid
