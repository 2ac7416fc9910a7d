// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "mrpt_plugins/report/run_record.h"

namespace hybrid {

// Lines of events.jsonl, see docs/events.md.
nlohmann::ordered_json sighting_line(std::size_t number, const RunRecord::Sighting& sighting);
nlohmann::ordered_json association_line(int keyframe, const AssociationEvent& event);
nlohmann::ordered_json decision_line(int keyframe, const DecisionEvent& event);
nlohmann::ordered_json merge_line(int keyframe, const MergeEvent& event);
nlohmann::ordered_json change_line(const RunRecord::Change& change);
nlohmann::ordered_json residual_line(std::size_t number, const RunRecord::Sighting& sighting);

/// [x, y, yaw], in space [x, y, z, yaw, pitch, roll].
nlohmann::ordered_json pose_json(const mrpt::poses::CPose3D& pose, bool is_3d);

/// A number or null.
nlohmann::ordered_json or_null(const std::optional<std::int64_t>& id);

}  // namespace hybrid
