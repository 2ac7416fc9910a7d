// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/input/keyframe_source.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {

/// Views of clouds of a run, evenly spread over it, to judge the path by.
class CloudArchive {
 public:
  static constexpr std::size_t kMost = 400;  ///< some 100 kB each

  /// Takes the clouds of keyframe number `number` of the map.
  void add(std::size_t number, const Keyframe& keyframe);

  /// All views laid out by the path of all keyframes.
  std::vector<PlacedCloud> placed(const Mapper& mapper, const Trajectory& keyframes) const;
  double reach() const { return reach_; }  ///< of the sensor [m]; 0 before the first cloud

 private:
  struct Entry {
    std::size_t keyframe = 0;
    std::shared_ptr<const CloudView> view;
  };
  void thin_out();

  std::vector<Entry> entries_;
  std::size_t stride_ = 1;  // of clouds that are kept
  std::size_t clouds_ = 0;
  double reach_ = 0;
};

}  // namespace hybrid
