// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/fixes/fix_mapper.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// What a mapping plugin is besides that maps fixes of satellite receivers.
class FixSource {
 public:
  virtual ~FixSource() = default;

  virtual const FixMapper& fix_mapper() const = 0;
  /// Where the map is on earth; nothing where it is not known.
  virtual std::optional<MapDatum> datum() const = 0;
  /// Before the first keyframe: where the map is on earth, which is a known one.
  virtual void adopt(const MapDatum& datum) = 0;
  /// Asked after each keyframe: true once, when that has become known. Then the first pose of the
  /// map is set free, and fixes that have waited are added by MappingPlugin::revise.
  /// `stands`: the log has ended, and had neither odometry nor scans that tell a motion.
  virtual bool find_datum(const MapView& map, bool stands) = 0;
};

/// The plugin that maps fixes; null where none does.
FixSource* fix_source_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins);

/// The discrete variables of fixes, each once.
std::vector<DiscreteKey> discrete_keys_of(const std::vector<FixEntry>& fixes);

/// Fixes at an estimate. Its arguments must outlive it.
class FixEstimator {
 public:
  FixEstimator(const std::optional<MapDatum>& datum, const Values& values,
               const Assignment& assignment, const Uncertainty& uncertainty)
      : datum_(datum), values_(values), assignment_(assignment), uncertainty_(uncertainty) {}

  FixEstimate operator()(const FixEntry& entry) const;

 private:
  void set_probabilities(const FixEntry& entry, FixEstimate& out) const;

  const std::optional<MapDatum>& datum_;
  const Values& values_;
  const Assignment& assignment_;
  const Uncertainty& uncertainty_;
};

}  // namespace hybrid
