// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

// Eigen with the alignment that the library was compiled with. Every header with an Eigen type in
// its interface includes this one, directly or through another: a program in which Eigen would
// allocate memory otherwise than the library frees it does not compile.
#include <Eigen/Core>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

static_assert(
    EIGEN_MAX_ALIGN_BYTES <= 16 && EIGEN_MAX_STATIC_ALIGN_BYTES <= 16,
    "Eigen would align its matrices otherwise than the library: use hybrid::hybrid of CMake, or "
    "compile with -DEIGEN_MAX_ALIGN_BYTES=16");
static_assert(
    EIGEN_MALLOC_ALREADY_ALIGNED == 1,
    "Eigen would allocate memory otherwise than the library, as it does under the address "
    "sanitizer: use hybrid::hybrid of CMake, or compile with "
    "-DEIGEN_MALLOC_ALREADY_ALIGNED=1");

}  // namespace hybrid
