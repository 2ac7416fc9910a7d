// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <string>

#include "mrpt_plugins/bridge/geodesy.h"

namespace HYBRID_API hybrid {

/// A satellite fix of a log to write.
struct SatelliteFix {
  double time = 0;  ///< [s], of the clock of the log.
  GeodeticPoint place;
  std::uint8_t quality = 1;  ///< As GGA numbers it: 0 invalid, 1 autonomous, 2 differential, 4 RTK
                             ///< fixed, 5 RTK float.
  double sigma = 0;          ///< Of east and of north [m]; 0: not known.
};

/// The observation of a fix: a message GGA with the height above the ellipsoid as its altitude and
/// a geoidal distance of 0; where sigma is known, a message BESTPOS as well, whose sigma of the
/// height is 0: not known.
mrpt::obs::CObservationGPS::Ptr satellite_fix(const SatelliteFix& fix, const std::string& label,
                                              const mrpt::poses::CPose3D& T_robot_antenna);

}  // namespace hybrid
