// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/mapping/motion.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// Where a log starts in a map, and after which of its keyframes that is known.
struct FoundStart {
  KnownStart start;
  std::size_t keyframe = 0;
  bool by_scans = false;  ///< or clouds, else by landmarks
};

/// Maps the log of one robot in a frame of its own until its landmarks or, in the plane, its laser
/// scans say where in the map they are. Where they do not up to its end, fixes of satellites do, if
/// both have them; else nothing. `odds` is the evidence needed. Throws as replay does.
std::optional<FoundStart> find_start(const ReplayRequest& request, std::size_t robot,
                                     const MapRecord& map, double odds);

/// The same where the start is roughly known: what laser scans of the first metres say of it, among
/// all places that it allows; nothing where none of these stands out.
std::optional<KnownStart> refine_start(const ReplayRequest& request, std::size_t robot,
                                       const MapRecord& map, double odds, const KnownStart& start);

}  // namespace hybrid
