// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace HYBRID_API hybrid {

/// The detections of a run, whether the map used them or not, kept in bounded memory: once there
/// are more than a budget, those of every second frame are given up.
class DetectionArchive {
 public:
  static constexpr std::size_t kBudget = 200000;  // detections, some 60 MB

  explicit DetectionArchive(std::size_t budget = kBudget) : budget_(budget) {}

  /// Takes the detections of keyframe number `number` of the map.
  void add(std::size_t number, const Keyframe& keyframe);

  /// All of them, laid out by the path of all keyframes, and by the poses of the sensors where the
  /// map calibrates these.
  std::vector<PlacedDetections> placed(const Mapper& mapper, const Trajectory& keyframes) const;

 private:
  struct Frame {
    std::size_t keyframe = 0;
    DetectionFrame detections;
  };

  void thin_out();

  std::size_t budget_;
  std::size_t count_ = 0;  // of detections
  std::vector<Frame> frames_;
};

}  // namespace hybrid
