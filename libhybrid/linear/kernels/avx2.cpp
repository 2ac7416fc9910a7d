// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#ifdef __x86_64__
#include "libhybrid/linear/kernels/dense.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

const Kernels kAvx2Kernels = DenseKernels<4>::table("AVX2");

}  // namespace hybrid
#endif
