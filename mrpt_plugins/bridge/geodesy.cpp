// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/geodesy.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/Math.hpp>

namespace hybrid {
namespace {

/// Columns are east, north and up at a place. Exact at multiples of 90 degrees.
Eigen::Matrix3d axes_at(const GeodeticPoint& place) {
  double sin_lat = 0, cos_lat = 0, sin_lon = 0, cos_lon = 0;
  GeographicLib::Math::sincosd(place.latitude, sin_lat, cos_lat);
  GeographicLib::Math::sincosd(place.longitude, sin_lon, cos_lon);
  Eigen::Matrix3d R;
  R << -sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon,  //
      cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon,    //
      0, cos_lat, sin_lat;
  return R;
}

}  // namespace

Eigen::Vector3d ecef_of(const GeodeticPoint& point) {
  Eigen::Vector3d ecef;
  GeographicLib::Geocentric::WGS84().Forward(point.latitude, point.longitude, point.altitude,
                                             ecef.x(), ecef.y(), ecef.z());
  return ecef;
}

GeodeticPoint geodetic_of(const Eigen::Vector3d& ecef) {
  GeodeticPoint point;
  GeographicLib::Geocentric::WGS84().Reverse(ecef.x(), ecef.y(), ecef.z(), point.latitude,
                                             point.longitude, point.altitude);
  return point;
}

LocalFrame::LocalFrame(const GeodeticPoint& datum)
    : datum_(datum), origin_(ecef_of(datum)), R_ecef_local_(axes_at(datum)) {}

Eigen::Vector3d LocalFrame::to_local(const GeodeticPoint& point) const {
  return R_ecef_local_.transpose() * (ecef_of(point) - origin_);
}

GeodeticPoint LocalFrame::to_geodetic(const Eigen::Vector3d& local) const {
  return geodetic_of(origin_ + R_ecef_local_ * local);
}

Eigen::Isometry3d LocalFrame::pose_in(const LocalFrame& other) const {
  const Eigen::Matrix3d R_other_ecef = other.R_ecef_local_.transpose();
  return Eigen::Translation3d(R_other_ecef * (origin_ - other.origin_)) *
         Eigen::Isometry3d(R_other_ecef * R_ecef_local_);
}

}  // namespace hybrid
