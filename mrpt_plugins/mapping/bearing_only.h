// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/mapping/class_model.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"
#include "mrpt_plugins/mapping/unplaced_landmarks.h"

namespace hybrid {

/// Directions, without ranges, to landmarks that the sensor identifies and may classify. A landmark
/// starts as a mixture of depths along the ray of its first sighting and enters the map once one
/// place dominates; its class then remembers all sightings.
class BearingOnlyKnownIds : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BearingOnlyKnownIds, hybrid)

 public:
  void configure(IniSection section) override;
  Contribution observe(const Frame& frame, const MapView& map) override;
  std::vector<std::string> class_names() const override { return classes_.names(); }

 private:
  void take(const DetectionFrame& seen, const Detection& detection, const Frame& frame,
            const MapView& map, Contribution& out);
  void add_sighting(std::int64_t id, const HypothesisBank::Measurement& measurement,
                    Contribution& out);
  void place(const PlacedLandmark& landmark, const MapView& map, Contribution& out);
  DiscreteKey class_key(std::int64_t id) const;

  std::vector<std::string> sensors_;
  ClassModel classes_;
  BankOptions bank_;
  double least_depth_ = 0.5, greatest_depth_ = 100;
  int depths_ = 16;
  UnplacedLandmarks unplaced_;
};

}  // namespace hybrid
