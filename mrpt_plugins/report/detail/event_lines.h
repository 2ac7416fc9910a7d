// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/report/run_record.h"

namespace hybrid {

// Lines of events.jsonl, see docs/events.md.
nlohmann::ordered_json sighting_line(std::size_t number, const RunRecord::Sighting& sighting);
nlohmann::ordered_json association_line(int keyframe, const AssociationEvent& event);
nlohmann::ordered_json decision_line(int keyframe, const DecisionEvent& event);
nlohmann::ordered_json merge_line(int keyframe, const MergeEvent& event);
nlohmann::ordered_json change_line(const RunRecord::Change& change);
nlohmann::ordered_json residual_line(std::size_t number, const RunRecord::Sighting& sighting);

/// Number, time and robot of the newest keyframe, its pose, and the state of the map after it.
nlohmann::ordered_json keyframe_json(const Mapper& mapper, const StepRecord& step);

}  // namespace hybrid
