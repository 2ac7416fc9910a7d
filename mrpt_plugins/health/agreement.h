// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/selection/closure_agreement.h"
#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// Whether what was measured far apart in time agrees in space, an entry for detections and one for
/// scans; one that is not judged where neither was seen again.
Health agreement_health(const Agreement& detections, const Agreement& scans,
                        const Agreement& clouds = {});

/// Whether scans show the surfaces of the map that a session is in; nothing where none was in view.
std::optional<HealthEntry> map_agreement_health(const Agreement& with_map);

/// Whether closures of a pose graph that were measured far apart in time agree with the path, or
/// with each other and against it; one that is not judged where no closure can be checked. `rival`
/// names one of the latter. The times over which it goes are numbers of poses.
HealthEntry closure_agreement_health(const ClosureAgreement& found, const std::string& rival);

/// The values of the entries of agreement over time among all of a run.
std::vector<double> agreement_values(const Health& health);

/// The worst verdict of the entries of agreement over time among all of a run; bad where it was not
/// judged.
HealthVerdict agreement_of(const Health& health);

}  // namespace hybrid
