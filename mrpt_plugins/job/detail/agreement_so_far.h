// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <vector>

#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/job/detail/cloud_archive.h"
#include "mrpt_plugins/job/detail/scan_outputs.h"
#include "mrpt_plugins/mapping/detection_archive.h"

namespace hybrid {

/// What the sensors of a run measured, beside its scans, to judge its path by.
struct SensorArchives {
  DetectionArchive detections;
  CloudArchive clouds;
};

/// Scans and clouds where the path has put them.
struct PlacedViews {
  PlacedViews(const ScanOutputs& outputs, const SensorArchives& measured, const Mapper& mapper,
              const Trajectory& path)
      : scans(outputs.placed(mapper, path)),
        clouds(measured.clouds.placed(mapper, path)),
        reach(measured.clouds.reach()) {}

  bool any() const { return !scans.empty() || !clouds.empty(); }

  std::vector<PlacedScan> scans;
  std::vector<PlacedCloud> clouds;
  double reach;  // of the sensor of the clouds [m]
};

/// Of what was measured, over time and with the map.
Health agreements(const SensorArchives& measured, const PlacedViews& views,
                  const Agreement& with_map, const Mapper& mapper, const Trajectory& path);

/// The agreement over time while a log runs. It is asked whenever the log has become longer by a
/// fifth, so that all answers together take some six times what the last one takes.
class AgreementSoFar {
 public:
  /// The entries for all keyframes of the mapper, where it is their turn at the time [s] of the
  /// newest one.
  std::optional<Health> at(double time, const ScanOutputs& scans, const SensorArchives& measured,
                           const Mapper& mapper);

 private:
  std::optional<double> begin_;  // of the log [s]
  double asked_ = 0;             // how long the log was when it was asked last [s]
};

}  // namespace hybrid
