// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/clouds/cloud_mapper.h"
#include "libhybrid/clouds/cloud_sweep.h"
#include "mrpt_plugins/input/clouds.h"
#include "mrpt_plugins/mapping/closure_factors.h"
#include "mrpt_plugins/mapping/cloud_follower.h"

namespace HYBRID_API hybrid {

/// Clouds of 3-D lidars and depth cameras: matches with local maps, and closures as CloudMapper
/// accepts them, are factors between poses of a map in space. Each robot has local maps and
/// closures of its own.
class PointClouds : public MappingPlugin, public CloudFollower {
  DEFINE_MRPT_OBJECT(PointClouds, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> observation_classes() const override;
  std::vector<std::string> uses() const override;
  bool suits(const LogContents& log) const override;
  bool ties_keyframes() const override { return true; }
  Contribution observe(const Frame& frame, const MapView& map) override;
  void applied(const Outcome& outcome) override;
  void refused() override;
  Contribution conclude(const MapView& map) override;
  void adopt_clouds(std::size_t robot, const std::vector<StoredCloud>& stored,
                    const UncertainMotion3& start) override;
  const CloudMapper* cloud_mapper(std::size_t robot) const override;
  std::vector<MeasuredClosure<SE3>> cloud_closures() const override;
  std::vector<LocalView> local_views() const override;
  std::map<std::string, double> statistics() const override;

 private:
  /// The clouds of a robot.
  struct Robot {
    explicit Robot(const CloudMapperOptions& options) : mapper(options) {}

    CloudMapper mapper;
    std::vector<Key> keys;  // by cloud of the mapper
    ClosureFactors factors;
    SweepVelocity velocity;
    std::optional<PointCloud> first;    // with times, until the second tells the motion
    bool lost_odometry = false;         // since the last frame with a cloud
    std::vector<Eigen::Vector3f> last;  // points of the last cloud, as they came
    std::size_t empty = 0;  // frames of clouds without a point, which the mapper has not
  };

  std::optional<UncertainMotion3> motion_to(const Robot& robot, const Frame& frame,
                                            const MapView& map) const;
  TrackedCloud add(Robot& robot, PointCloud cloud,
                   const std::optional<UncertainMotion3>& odometry) const;
  static void add_first(Robot& robot, const SE3::Tangent& velocity);
  void follow_closures(Robot& robot, const MapView& map, Contribution& out) const;
  std::vector<StoredCloud> places_of(const Robot& robot) const;
  std::map<std::string, double> candidate_statistics() const;

  CloudMapperOptions options_;
  std::map<std::size_t, Robot> robots_;
  bool concluded_ = false;
  std::size_t between_robots_ = 0;  // closures
};

}  // namespace hybrid
