// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#ifdef __x86_64__
#include "libhybrid/linear/kernels/dense.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

const Kernels kAvx512Kernels = DenseKernels<8>::table("AVX-512F");

}  // namespace hybrid
#endif
