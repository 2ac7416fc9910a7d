// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/initialization/direction_tracker.h"
#include "libhybrid/landmarks/landmark_association.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// Range and bearing to landmarks without ids, with or without classes: LandmarkAssociation as a
/// plugin. Directions without ranges are followed (DirectionTracker) until they tell the range of
/// their thing, and are then taken together as one detection with a range.
class BearingRangeAssociation : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BearingRangeAssociation, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override {
    return {"CObservationBearingRange", "CObservationClassedBearingRange"};
  }
  bool suits(const LogContents& log) const override {
    // Another plugin maps ranges with ids, and this one would take them as well.
    if (log.with_range.mostly_identified()) return false;
    const auto suits = [](const DetectionCounts& counts) {
      return counts.all > 0 && !counts.mostly_identified();
    };
    return suits(log.with_range) || suits(log.without_range);
  }
  void adopt(const KnownMap& known, bool is_3d) override { association_.adopt(known, is_3d); }
  std::map<std::int64_t, double> existence() const override { return association_.existence(); }
  std::map<std::int64_t, LandmarkSize> sizes(const MapView& map) const override {
    return association_.sizes(map);
  }
  Contribution observe(const Frame& frame, const MapView& map) override;
  void applied(const Outcome& outcome) override {
    if (asked_) association_.applied(outcome);
  }
  void refused() override {
    if (asked_) association_.refused();
  }
  Contribution revise(const MapView& map) override {
    asked_ = true;
    return association_.revise(map);
  }
  Contribution conclude(const MapView& map) override {
    asked_ = true;
    return association_.conclude(map);
  }
  std::vector<AssociationDecision> decisions(const MapView& map) const override {
    return association_.decisions(map);
  }
  std::vector<Mover> movers(const std::vector<double>& times, const MapView& map) const override {
    return association_.movers(times, map);
  }
  std::map<std::string, double> statistics() const override;
  std::vector<std::string> class_names() const override { return association_.class_names(); }

 private:
  void follow(const Frame& frame, const MapView& map);

  LandmarkAssociation association_;
  bool asked_ = true;  // whether the last contribution is of association_
  std::vector<std::string> sensors_;
  DirectionTracker directions_;
  double every_ = 1;              // way between two releases [m]
  std::optional<Key> last_pose_;  // of the frame before, where directions are followed
  Eigen::Isometry3d T_map_last_;  // as it was then
  double way_ = 0;                // since the last release [m]
};

}  // namespace hybrid
