// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/scan_archive.h"

namespace hybrid {
namespace {

std::size_t bytes_of(const LaserScan& scan) {
  return scan.ranges.size() * sizeof(float);
}

bool is_at_keyframe(const LaserScan& scan) {
  return scan.T_keyframe_robot.matrix().isIdentity(0);
}

}  // namespace

void ScanArchive::add(std::size_t number, const Keyframe& keyframe) {
  robots_.push_back(keyframe.robot);
  for (const LaserScan& scan : keyframe.scans) {
    entries_.push_back({number, is_at_keyframe(scan), scan});
    ranges_ += bytes_of(scan);
  }
  if (ranges_ > budget_) thin_out();
}

void ScanArchive::thin_out() {
  while (ranges_ > budget_ / 2) {
    if (!give_up_every_second(false) && !give_up_every_second(true)) return;
  }
}

/// Gives up the ranges of every second scan that still has some, of those at keyframes or of the
/// others; returns whether there were any.
bool ScanArchive::give_up_every_second(bool own) {
  bool keeps = true, any = false;
  for (Entry& entry : entries_) {
    if (entry.is_own != own || entry.scan.ranges.empty()) continue;
    if (!keeps) {
      ranges_ -= bytes_of(entry.scan);
      entry.scan.ranges = {};
      ++given_up_;
      any = true;
    }
    keeps = !keeps;
  }
  return any;
}

}  // namespace hybrid
