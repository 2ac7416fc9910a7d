// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/scans/laser_scan.h"
#include "mrpt_plugins/input/keyframe_source.h"

namespace HYBRID_API hybrid {

/// The laser scans of a run, kept for its outputs in bounded memory: once the ranges of all scans
/// take more than a budget, those of every second scan between keyframes are given up, and when
/// none of these is left, those of every second keyframe. PathArchive knows where the robot was at
/// all of them.
class ScanArchive {
 public:
  static constexpr std::size_t kBudget = std::size_t{256} << 20;  // bytes of ranges

  explicit ScanArchive(std::size_t budget = kBudget) : budget_(budget) {}

  /// One scan; without ranges where they were given up.
  struct Entry {
    std::size_t keyframe = 0;  ///< whose frame it is placed in, in MapResult::trajectory
    bool is_own = false;       ///< taken at the keyframe itself, else before it
    LaserScan scan;
  };

  /// Takes the scans of keyframe number `number` of the map; numbers rise one by one.
  void add(std::size_t number, const Keyframe& keyframe);

  const std::vector<Entry>& entries() const { return entries_; }
  /// The robot of a keyframe that was added.
  std::size_t robot_of(std::size_t keyframe) const { return robots_[keyframe]; }
  /// Number of scans whose ranges were given up.
  std::size_t given_up() const { return given_up_; }

 private:
  void thin_out();
  bool give_up_every_second(bool own);

  std::size_t budget_;
  std::size_t ranges_ = 0;  // bytes
  std::size_t given_up_ = 0;
  std::vector<Entry> entries_;
  std::vector<std::size_t> robots_;  // of the keyframes
};

}  // namespace hybrid
