// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/landmarks/landmark_association.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// Range and bearing to landmarks without ids, with or without classes: LandmarkAssociation as a
/// plugin.
class BearingRangeAssociation : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BearingRangeAssociation, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override {
    return {"CObservationBearingRange", "CObservationClassedBearingRange"};
  }
  bool suits(const LogContents& log) const override {
    return log.with_range.all > 0 && !log.with_range.mostly_identified();
  }
  void adopt(const KnownMap& known, bool is_3d) override { association_.adopt(known, is_3d); }
  std::map<std::int64_t, double> existence() const override { return association_.existence(); }
  Contribution observe(const Frame& frame, const MapView& map) override {
    return association_.observe(frame.view(), map);
  }
  void applied(const Outcome& outcome) override { association_.applied(outcome); }
  void refused() override { association_.refused(); }
  Contribution revise(const MapView& map) override { return association_.revise(map); }
  Contribution conclude(const MapView& map) override { return association_.conclude(map); }
  std::vector<AssociationDecision> decisions(const MapView& map) const override {
    return association_.decisions(map);
  }
  std::vector<Mover> movers(const std::vector<double>& times, const MapView& map) const override {
    return association_.movers(times, map);
  }
  std::map<std::string, double> statistics() const override { return association_.statistics(); }
  std::vector<std::string> class_names() const override { return association_.class_names(); }

 private:
  LandmarkAssociation association_;
};

}  // namespace hybrid
