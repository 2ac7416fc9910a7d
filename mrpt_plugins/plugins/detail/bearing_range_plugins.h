// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace hybrid {

/// The ids that sensors read, one in some hundred of them wrong.
struct IdReading {
  std::vector<std::string> sensors;  ///< labels of those to use; empty: all
  double huber_width = 3;            ///< beyond which a cost grows only linearly [sigmas]; 0: none

  void configure(IniSection& section);
  Loss loss() const { return huber_width > 0 ? Loss::huber(huber_width) : Loss(); }
};

/// Range and bearing to landmarks that the sensor identifies: a factor with Huber's loss per
/// sighting.
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
  IdReading ids_;
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
  IdReading ids_;
  ClassModel classes_;
};

}  // namespace hybrid
