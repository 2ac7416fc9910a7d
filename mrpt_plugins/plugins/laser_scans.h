// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/scans/scan_mapper.h"
#include "mrpt_plugins/mapping/closure_factors.h"
#include "mrpt_plugins/mapping/scan_follower.h"

namespace HYBRID_API hybrid {

/// Planar laser scans: matches with local maps, and closures as ScanMapper accepts them, are
/// factors between poses of the map. The scans of several robots are not mixed: each robot has
/// local maps and closures of its own.
class LaserScans : public MappingPlugin, public ScanFollower {
  DEFINE_MRPT_OBJECT(LaserScans, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override { return {"CObservation2DRangeScan"}; }
  bool suits(const LogContents& log) const override { return log.scans > 0; }
  bool takes_scans_between() const override { return true; }
  Contribution observe(const Frame& frame, const MapView& map) override;
  void applied(const Outcome& outcome) override;
  void refused() override;
  Contribution conclude(const MapView& map) override;
  void expect(std::size_t robot, bool has_odometry) override;
  std::optional<ScanMotion> scan_motion() const override { return motion_; }
  void adopt_scans(std::size_t robot, const std::vector<StoredScans>& stored,
                   const UncertainMotion& start) override;
  const ScanMapper* scan_mapper(std::size_t robot) const override;
  std::vector<LocalScans> local_scans() const override;
  std::vector<MeasuredClosure<SE2>> scan_closures() const override;
  std::map<std::string, double> statistics() const override;

 private:
  /// The scans of a robot.
  struct Robot {
    explicit Robot(const ScanMapperOptions& options) : mapper(options) {}

    ScanMapper mapper;
    std::vector<Key> keys;             // of the keyframes of the mapper
    ClosureFactors factors;            // of its closures
    std::size_t matches = 0;           // of keyframes
    std::size_t scans = 0, blind = 0;  // tracked, and of these with few returns
    bool is_next = false;        // the frame before had scans, and odometry from there is known
    bool lost_odometry = false;  // since the last frame with scans
  };

  std::optional<SE2> motion_to(const Robot& robot, const Frame& frame, const MapView& map) const;
  TrackedScan track(Robot& robot, const Frame& frame, std::optional<SE2> from_before,
                    std::vector<SE2>& T_before_scan);
  TrackedScan track_all(Robot& robot, const Frame& frame, const MapView& map,
                        std::vector<SE2>& T_before_scan);
  ScanMotion motion_by(const Robot& robot, const TrackedScan& tracked,
                       std::vector<SE2> T_before_scan) const;
  void follow_closures(Robot& robot, const MapView& map, Contribution& out) const;
  bool is_accepted(const Robot& robot, std::size_t closure) const;

  ScanMapperOptions options_;
  std::map<std::size_t, Robot> robots_;
  std::size_t robot_ = 0;             // whose frame it is
  std::optional<ScanMotion> motion_;  // to the frame observed last
  bool concluded_ = false;
  std::size_t between_robots_ = 0;  // closures
};

}  // namespace hybrid
