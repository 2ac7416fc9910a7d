// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

/// One file each, compiled for these instructions: whoever uses one must know that the processor
/// has them.
extern const Kernels kBaselineKernels;
extern const Kernels kAvx2Kernels;
extern const Kernels kAvx512Kernels;

}  // namespace hybrid
