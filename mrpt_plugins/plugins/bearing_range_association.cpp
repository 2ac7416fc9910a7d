// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/bearing_range_association.h"

#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BearingRangeAssociation, hybrid)

namespace hybrid {

void BearingRangeAssociation::configure(IniSection section) {
  const std::vector<std::string> sensors = read_sensors(section);
  const ClassModel classes = read_class_model(section);
  association_ = LandmarkAssociation(read_association_options(section), classes, sensors);
}

}  // namespace hybrid
