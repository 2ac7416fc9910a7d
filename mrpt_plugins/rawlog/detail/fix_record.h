// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationGPS.h>

#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {

/// A satellite fix number by number, with its messages GGA and RMC of NMEA and BESTPOS of Novatel;
/// other messages are left out. Its time stamp and label are not written.
void write_fix(ByteWriter& out, const mrpt::obs::CObservationGPS& fix);

/// Reads what write_fix() wrote; throws Error for anything else. The numbers may be any.
void read_fix(ByteReader& in, mrpt::obs::CObservationGPS& fix);

}  // namespace hybrid
