// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>

#include "libhybrid/export.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A place on Earth by the ellipsoid of WGS84.
struct GeodeticPoint {
  double latitude = 0;   ///< [deg], north is positive; not a number beyond 90.
  double longitude = 0;  ///< [deg], east is positive.
  double altitude = 0;   ///< Above the ellipsoid [m].
};

/// Earth-centred, Earth-fixed coordinates [m]: x to latitude and longitude 0, z to the north pole.
Eigen::Vector3d ecef_of(const GeodeticPoint& point);

/// Their inverse, within a few nanometres up to altitudes of 1e7 m. Longitudes are within +-180.
GeodeticPoint geodetic_of(const Eigen::Vector3d& ecef);

/// The Cartesian frame of a datum: east, north and up along the normal of the ellipsoid [m]. At a
/// pole, north is the direction in which the meridian of the longitude crosses it.
class LocalFrame {
 public:
  explicit LocalFrame(const GeodeticPoint& datum);

  Eigen::Vector3d to_local(const GeodeticPoint& point) const;
  GeodeticPoint to_geodetic(const Eigen::Vector3d& local) const;

  /// Where this frame is in another one.
  Eigen::Isometry3d pose_in(const LocalFrame& other) const;

  const GeodeticPoint& datum() const { return datum_; }

 private:
  GeodeticPoint datum_;
  Eigen::Vector3d origin_;        // of the datum, ECEF
  Eigen::Matrix3d R_ecef_local_;  // columns: east, north, up
};

}  // namespace hybrid
