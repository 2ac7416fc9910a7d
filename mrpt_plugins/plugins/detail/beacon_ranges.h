// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationBeaconRanges.h>

#include <deque>
#include <string>
#include <vector>

#include "libhybrid/initialization/pending_landmarks.h"
#include "libhybrid/initialization/placed_landmarks.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace hybrid {

/// Ranges to beacons (CObservationBeaconRanges) at unknown positions. A beacon starts as a mixture
/// of positions on the circle, or sphere, of its first range, and is placed in the map once one of
/// them is far more likely than the rest. Every range is a mixture over its beacon and a false
/// range or, if the sensor does not identify the beacon (INVALID_BEACON_ID), over all placed
/// beacons and a false range (eq. 18). The solver revises these choices with every keyframe. A
/// beacon most of whose latest ranges are false is misplaced: it is removed from the map and starts
/// as a mixture again.
class BeaconRanges : public MappingPlugin {
  DEFINE_MRPT_OBJECT(BeaconRanges, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override { return {"CObservationBeaconRanges"}; }
  void adopt(const KnownMap& known, bool is_3d) override;
  Contribution observe(const Frame& frame, const MapView& map) override;
  /// Adds the ranges that still wait, and says what has no place.
  Contribution conclude(const MapView& map) override;
  void applied(const Outcome& outcome) override;
  void refused() override;
  Contribution revise(const MapView& map) override;
  /// Attributions of ranges to an unknown beacon, without true ids.
  std::vector<AssociationDecision> decisions(const MapView& map) const override;

 private:
  struct Range {
    Key pose;
    double range = 0, sigma = 0;
    Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  // on the robot
    std::size_t frame = 0;
    std::size_t measurement = 0;  // index in its frame
  };
  /// The association of a range to one of the beacons that were known then, or to none.
  struct Choice {
    Range range;
    Key key;
    std::vector<std::int64_t> beacons;
    std::size_t place = 0;  // of its factor among the hybrid ones of the contribution
    Handle factor = {};
  };

  void take(const mrpt::obs::CObservationBeaconRanges& observation, const Frame& frame,
            const MapView& map, Contribution& out);
  void add_unplaced(std::int64_t id, const Range& range, const Frame& frame, const MapView& map);
  PlacedLandmarks::Measurement measurement_of(std::int64_t id, const Range& range,
                                              bool is_3d) const;
  void begin();
  double reach() const;
  void add_known(std::int64_t id, const PlacedLandmarks::Measurement& measurement,
                 const FrameValues& values, Contribution& out);
  Key add_choice(const std::vector<ContinuousFactorPtr>& hypotheses, const FrameValues& values,
                 Contribution& out);
  void place(const PlacedLandmark& landmark, const FrameValues& values, bool is_3d,
             Contribution& out);
  void settle_ambiguous(const FrameValues& values, bool is_3d, std::size_t delay,
                        Contribution& out);

  std::vector<std::string> sensors_;
  BankOptions bank_;
  double sigma_ = 0, sigma_factor_ = 1, max_range_ = 0;
  int circle_hypotheses_ = 24, sphere_hypotheses_ = 96, delay_ = 10;
  PendingLandmarks unplaced_;
  PlacedLandmarks placed_;
  std::vector<std::int64_t> known_;         // beacons in the map, in the order of placement
  std::deque<Range> ambiguous_;             // waiting ranges to an unknown beacon, oldest first
  std::size_t frames_ = 0;                  // number of keyframes so far
  std::uint64_t choices_ = 0;               // discrete variables made so far
  std::vector<Choice> identified_;          // associations of ranges to an unknown beacon
  std::vector<std::int64_t> known_before_;  // before the last contribution
  std::size_t identified_before_ = 0;       // their number before it
  std::vector<Choice> taken_back_;          // that it removes, whose ranges wait again
  std::size_t measurements_ = 0;            // number of ranges of the present frame
  double log_ranges_ = 0;                   // sum of the logarithms of all ranges [ln m]
  std::size_t ranges_ = 0;                  // how many they are
  bool concluded_ = false;                  // what has no place was said
};

}  // namespace hybrid
