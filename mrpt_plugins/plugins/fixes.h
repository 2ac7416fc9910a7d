// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// Fixes of satellite receivers: positions in the axes of a datum, with modes (libhybrid/fixes).
/// The datum is the first fix that the next one confirms.
class Fixes : public MappingPlugin, public FixSource {
  DEFINE_MRPT_OBJECT(Fixes, hybrid)

 public:
  void configure(IniSection section) override;
  std::vector<std::string> uses() const override { return {"CObservationGPS"}; }
  bool takes_scans_between() const override { return true; }
  bool ties_keyframes() const override { return true; }  // by errors that last
  Contribution observe(const Frame& frame, const MapView& map) override;
  Contribution revise(const MapView& map) override { return mapper_.revise(map); }
  Contribution conclude(const MapView& map) override;
  void refused() override { mapper_.refused(); }
  std::map<std::string, double> statistics() const override;

  const FixMapper& fix_mapper() const override { return mapper_; }
  std::optional<MapDatum> datum() const override;
  void adopt(const MapDatum& datum) override;
  bool find_datum(const MapView& map, bool stands) override {
    return mapper_.find_datum(map, stands);
  }

 private:
  FixMapper mapper_;
  DatumFinder datum_;
  bool concluded_ = false;
};

}  // namespace hybrid
