// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/kernels/dense.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {

const Kernels kBaselineKernels = DenseKernels<2>::table("baseline");

}  // namespace hybrid
