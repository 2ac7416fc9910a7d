// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/scans/scan_mapper.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// Planar laser scans: matches with local maps, and closures as ScanMapper accepts them, are
/// factors between poses of the map.
class LaserScans : public MappingPlugin {
  DEFINE_MRPT_OBJECT(LaserScans, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override { return {"CObservation2DRangeScan"}; }
  bool suits(const LogContents& log) const override { return log.scans > 0; }
  bool takes_scans_between() const override { return true; }
  Contribution observe(const Frame& frame, const MapView& map) override;
  void applied(const Outcome& outcome) override;
  void refused() override { asked_.clear(); }
  Contribution conclude(const MapView& map) override;
  std::map<std::string, double> statistics() const override;

 private:
  std::optional<SE2> motion_to(const Frame& frame, const MapView& map) const;
  TrackedScan track(const Frame& frame, std::optional<SE2> from_before);
  void add_factor(const KeyframeMotion& motion, std::size_t to, const MapView& map,
                  Contribution& out) const;
  void follow_closures(const MapView& map, Contribution& out);

  ScanMapperOptions options_;
  std::optional<ScanMapper> mapper_;
  std::vector<Key> keys_;                        // of the keyframes of the mapper
  std::optional<Key> last_pose_;                 // of the last frame with scans
  std::vector<std::optional<Handle>> closures_;  // in the map, by closure of the mapper
  /// Closures whose factors are the last ones of the contribution under way.
  std::vector<std::size_t> asked_;
  bool concluded_ = false;
};

}  // namespace hybrid
