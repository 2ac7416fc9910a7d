// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

std::vector<const Kernels*> find_supported() {
  std::vector<const Kernels*> found = {&kBaselineKernels};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) found.push_back(&kAvx2Kernels);
  if (__builtin_cpu_supports("avx512f")) found.push_back(&kAvx512Kernels);
#endif
  return found;
}

}  // namespace

const std::vector<const Kernels*>& supported_kernels() {
  static const std::vector<const Kernels*> supported = find_supported();
  return supported;
}

const Kernels& kernels() {
  static const Kernels& widest = *supported_kernels().back();
  return widest;
}

}  // namespace hybrid
