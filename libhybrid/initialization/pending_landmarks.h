// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "libhybrid/initialization/gaussian_sum_initializer.h"
#include "libhybrid/landmarks/contribution.h"

namespace HYBRID_API hybrid {

/// A landmark that has just got its place.
struct PlacedLandmark {
  std::int64_t id = 0;
  Eigen::VectorXd point;
  std::vector<GaussianSumInitializer::Measurement> measurements;
};

/// Landmarks with ids that were seen but have no place in the map yet.
class PendingLandmarks {
 public:
  /// Takes a measurement of one; `candidates` gives the places that it allows by itself, for the
  /// first one and where the places so far explain too little.
  void add(std::int64_t id, GaussianSumInitializer::Measurement measurement,
           const BankOptions& options,
           const std::function<std::vector<Eigen::VectorXd>()>& candidates);

  /// Refines those measured since the last call and hands over, and forgets, those that are placed.
  std::vector<PlacedLandmark> place(const KeyframeView& frame, const MapView& map,
                                    const BankOptions& options);

  /// How many measurements are of landmarks that have no place, by the reason.
  std::map<std::string, int> unplaced(const BankOptions& options) const;

  /// Whether one of them was measured within the last `calls` calls of `place`.
  bool measured_lately(std::size_t calls) const;

 private:
  struct Unplaced {
    GaussianSumInitializer initializer;
    std::size_t last_measured = 0;  // before which call of `place`
    int measured = 0;               // how many times
  };

  std::map<std::int64_t, Unplaced> unplaced_;
  std::set<std::int64_t> touched_;
  std::size_t calls_ = 0;
};

/// The values of the variables at a keyframe: its pose where it is expected, all else by the map.
class FrameValues {
 public:
  FrameValues(const KeyframeView& frame, const MapView& map);
  /// Where no keyframe is to come: all by the map.
  explicit FrameValues(const MapView& map) : map_(map.values) {}
  const double* operator()(Key key) const;

 private:
  Values newest_;
  const Values& map_;
};

}  // namespace hybrid
