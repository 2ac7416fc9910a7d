// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

/// Each is in a file of its own, compiled for its instructions: it may be used only if the
/// processor has them.
extern const Kernels kBaselineKernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;

}  // namespace hybrid
