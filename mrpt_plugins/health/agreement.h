// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/health/health.h"

namespace HYBRID_API hybrid {

/// Whether what was measured far apart in time agrees in space, an entry for detections and one for
/// scans; one that is not judged where neither was seen again.
Health agreement_health(const Agreement& detections, const Agreement& scans);

/// The worst verdict of these entries among all of a run; bad where it was not judged.
HealthVerdict agreement_of(const Health& health);

}  // namespace hybrid
