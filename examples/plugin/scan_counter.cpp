// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Example of a mapping plugin that reads further observations: it requests laser scans, adds
// nothing to the map, and reports the number of rays.

#include <mrpt/obs/CObservation2DRangeScan.h>

#include "mrpt_plugins/mapping/register_plugin.h"

namespace example {

class ScanCounter : public hybrid::MappingPlugin {
  DEFINE_MRPT_OBJECT(ScanCounter, example)

 public:
  void configure(hybrid::IniSection section) override {
    asks_ = section.get("asks", asks_, "ask for the scans");
  }

  std::vector<std::string> observation_classes() const override {
    if (!asks_) return {};
    return {"CObservation2DRangeScan"};
  }

  hybrid::Contribution observe(const hybrid::Frame& frame, const hybrid::MapView&) override {
    for (const auto& observation : frame.observations) {
      using Scan = mrpt::obs::CObservation2DRangeScan;
      const auto* scan = dynamic_cast<const Scan*>(observation.get());
      if (scan != nullptr) rays_ += scan->getScanSize();
    }
    return {};
  }

  std::map<std::string, double> statistics() const override {
    return {{"rays", static_cast<double>(rays_)}};
  }

 private:
  bool asks_ = true;
  std::size_t rays_ = 0;
};

}  // namespace example

HYBRID_REGISTER_PLUGIN(ScanCounter, example)
