// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/initialization/pending_landmarks.h"
#include "libhybrid/initialization/placed_landmarks.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace hybrid {

/// Directions without ranges to landmarks that the sensor identifies and may classify. A landmark
/// starts as a mixture of depths along the ray of its first sighting, and is placed in the map once
/// one of them is far more likely than the rest; its class variable then gets the scores of all its
/// sightings. Each direction is right or false (eq. 17), which the solver revises with every
/// keyframe. A landmark most of whose latest sightings are false is misplaced: it is removed from
/// the map and starts as a mixture again.
class BearingOnlyKnownIds : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BearingOnlyKnownIds, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override { return {"CObservationClassedBearingRange"}; }
  bool suits(const LogContents& log) const override {
    return log.without_range.mostly_identified();
  }
  void adopt(const KnownMap& known, bool is_3d) override;
  Contribution observe(const Frame& frame, const MapView& map) override;
  /// Says what has no place.
  Contribution conclude(const MapView& map) override;
  void applied(const Outcome& outcome) override;
  void refused() override;
  Contribution revise(const MapView& map) override;
  std::vector<std::string> class_names() const override { return classes_.names(); }

 private:
  using Measurement = GaussianSumInitializer::Measurement;

  void take(const DetectionFrame& seen, const Detection& detection, const Frame& frame,
            const MapView& map, Contribution& out);
  void add_sighting(std::int64_t id, const Measurement& measurement, Contribution& out);
  void place(const PlacedLandmark& landmark, const MapView& map, Contribution& out);
  DiscreteKey class_key(std::int64_t id) const;

  std::vector<std::string> sensors_;
  ClassModel classes_;
  BankOptions bank_;
  double least_depth_ = 0.5, greatest_depth_ = 100;
  int depths_ = 16;
  PendingLandmarks unplaced_;
  PlacedLandmarks placed_;
  std::uint64_t choices_ = 0;  // discrete variables made so far
  bool concluded_ = false;     // what has no place was said
};

}  // namespace hybrid
