// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace hybrid {

/// Range and bearing to landmarks that the sensor identifies: a Gaussian factor per sighting, with
/// Huber's loss if ids may be misread.
class BearingRangeKnownIds : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BearingRangeKnownIds, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override {
    return {"CObservationBearingRange", "CObservationClassedBearingRange"};
  }
  bool suits(const LogContents& log) const override {
    return log.with_range.mostly_identified() && !log.with_range.mostly_classified();
  }
  void adopt(const KnownMap& known, bool is_3d) override;
  Contribution observe(const Frame& frame, const MapView& map) override;

 private:
  std::vector<std::string> sensors_;
  double huber_width_ = 0;
};

/// The same with a class per landmark as a discrete variable: the semantic factor of eq. 19 per
/// sighting, and a prior per landmark.
class ClassedBearingRangeKnownIds : public MappingPlugin {
  DEFINE_MRPT_OBJECT(ClassedBearingRangeKnownIds, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override {
    return {"CObservationBearingRange", "CObservationClassedBearingRange"};
  }
  bool suits(const LogContents& log) const override {
    return log.with_range.mostly_identified() && log.with_range.mostly_classified();
  }
  void adopt(const KnownMap& known, bool is_3d) override;
  Contribution observe(const Frame& frame, const MapView& map) override;
  std::vector<std::string> class_names() const override { return classes_.names(); }

 private:
  std::vector<std::string> sensors_;
  ClassModel classes_;
};

}  // namespace hybrid
