// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/bridge/timed_pose.h"

namespace HYBRID_API hybrid {

// Numbers of a report, with the digits that one can see. A position has four decimals [m], all else
// four significant digits; what is not finite becomes null.

nlohmann::ordered_json decimals(double value, int places = 4);
nlohmann::ordered_json digits(double value);
nlohmann::ordered_json decimals(const std::vector<double>& values, int places = 4);
nlohmann::ordered_json digits(const std::vector<double>& values);

/// The value or null.
template <class T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// An object of empty columns.
nlohmann::ordered_json empty_columns(std::initializer_list<const char*> names);

/// Coordinates as columns: {"x": [..], "y": [..]}, and "z" where the map is in space.
nlohmann::ordered_json coordinates(const std::vector<Eigen::Vector3d>& points, bool is_3d);
/// The same of poses, with "t" [s after the first], and "yaw", in space also "pitch" and "roll".
nlohmann::ordered_json pose_columns(const Trajectory& trajectory, bool is_3d);

/// Whole multiples of a unit, each less the one before: small numbers that compress well.
nlohmann::ordered_json steps_of(const std::vector<double>& values, double origin, double unit);

}  // namespace hybrid
