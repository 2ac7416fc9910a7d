// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

namespace hybrid {

/// Dot product of two arrays of n doubles, on the widest registers there are.
double dot(const double* a, const double* b, int n);

}  // namespace hybrid
