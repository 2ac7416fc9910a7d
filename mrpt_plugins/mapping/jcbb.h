// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/mapping/frame_association.h"

namespace hybrid {

/// Joint compatibility branch and bound by mrpt::slam::data_association_full_covariance. MRPT does
/// not wrap angles, so all yaws are turned first such that the widest gap between them lies at
/// +-pi.
Matching joint_compatibility(const FrameCandidates& candidates, double gate);

}  // namespace hybrid
