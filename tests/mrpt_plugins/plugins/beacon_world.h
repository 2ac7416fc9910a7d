// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <mrpt/obs/CObservationBeaconRanges.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid::testing {

using mrpt::poses::CPose3D;

/// A robot that drives a curve among four beacons; what it measures has the noise it states.
struct BeaconWorld {
  bool is_3d;
  std::mt19937 random;
  std::vector<Eigen::Vector3d> beacons;

  explicit BeaconWorld(bool in_space, unsigned seed = 5) : is_3d(in_space), random(seed) {
    const double h = is_3d ? 1.0 : 0.0;
    beacons = {{6, 1, h}, {-3, 7, -2 * h}, {2, -6, 3 * h}, {9, 8, -h}};
  }
  double uniform() { return std::uniform_real_distribution<double>()(random); }
  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random); }

  CPose3D true_pose(int i) const {
    const double a = 0.15 * i;
    return {4 * std::sin(a), 4 - 4 * std::cos(a), is_3d ? std::sin(2 * a) : 0.0, a, 0, 0};
  }

  Keyframe keyframe(int i) {
    Keyframe out;
    out.row = static_cast<std::size_t>(i);
    out.time = i;
    if (i == 0) return out;
    OdometryIncrement odometry;
    odometry.mean =
        (true_pose(i) - true_pose(i - 1)) + CPose3D(gauss(0.02), gauss(0.02), 0, gauss(0.01), 0, 0);
    odometry.is_planar = !is_3d;
    odometry.covariance.diagonal() << 4e-4, 4e-4, 4e-4, 1e-4, 1e-4, 1e-4;
    out.odometry = odometry;
    return out;
  }

  Keyframe with_ranges(int i, double unknown_share) {
    Keyframe out = keyframe(i);
    auto seen = mrpt::obs::CObservationBeaconRanges::Create();
    seen->stdError = 0.05F;
    for (std::size_t id = 0; id < beacons.size(); ++id) {
      mrpt::obs::CObservationBeaconRanges::TMeasurement m;
      m.sensorLocationOnRobot = {0.1, 0, 0};
      const auto antenna = true_pose(i).composePoint({0.1, 0, 0});
      const double distance =
          (beacons[id] - Eigen::Vector3d(antenna.x, antenna.y, antenna.z)).norm();
      m.sensedDistance = static_cast<float>(distance + gauss(0.05));
      const bool hidden = uniform() < unknown_share;
      m.beaconID = hidden ? mrpt::obs::INVALID_BEACON_ID : static_cast<std::int32_t>(id);
      seen->sensedData.push_back(m);
    }
    out.observations = {seen};
    return out;
  }

  /// Directions with ranges and classes.
  Keyframe with_detections(int i, bool with_ids) {
    Keyframe out = with_bearings(i);
    DetectionFrame& frame = out.detections[0];
    frame.has_range = true;
    for (std::size_t id = 0; id < beacons.size(); ++id) {
      Detection& d = frame.detections[id];
      const auto p = true_pose(i).translation();
      d.range = (beacons[id] - Eigen::Vector3d(p.x, p.y, p.z)).norm() + gauss(0.05);
      d.covariance(0, 0) = 0.0025;
      if (!with_ids) d.id.reset();
    }
    return out;
  }

  /// A share of the bearings is false: anywhere.
  Keyframe with_bearings(int i, double false_share = 0) {
    Keyframe out = keyframe(i);
    DetectionFrame frame;
    frame.is_3d = is_3d;
    frame.has_range = false;
    frame.class_names = {"lamp", "door"};
    for (std::size_t id = 0; id < beacons.size(); ++id) {
      Detection d;
      true_pose(i).sphericalCoordinates({beacons[id].x(), beacons[id].y(), beacons[id].z()},
                                        d.range, d.yaw, d.pitch);
      d.range = 0;
      d.yaw += gauss(0.01);
      d.pitch = is_3d ? d.pitch + gauss(0.01) : 0.0;
      if (false_share > 0 && uniform() < false_share) {
        d.yaw = (2 * uniform() - 1) * M_PI;
        if (is_3d) d.pitch = std::asin(2 * uniform() - 1);
      }
      d.id = static_cast<std::int64_t>(id);
      d.class_probabilities =
          id % 2 == 0 ? std::vector<double>{0.7, 0.3} : std::vector<double>{0.2, 0.8};
      d.covariance.diagonal() << 1, 1e-4, is_3d ? 1e-4 : 0.0;
      frame.detections.push_back(d);
    }
    out.detections = {frame};
    return out;
  }
};

inline Mapper make_mapper(const std::string& plugin, bool is_3d) {
  IniFile ini;
  return {read_motion_options(ini),
          {make_plugin(plugin, ini)},
          make_backend(ini.section("solver")),
          is_3d};
}

}  // namespace hybrid::testing
