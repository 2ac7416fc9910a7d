// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Entries of the lower triangle of a symmetric matrix of order n, packed column by column.
inline std::size_t packed_size(std::size_t n) {
  return n * (n + 1) / 2;
}

/// Column c of such a triangle, as a pointer to its entries by row, from the diagonal on.
template <class T>
T* packed_column(T* triangle, std::size_t n, std::size_t c) {
  return triangle + (c * n - c * (c + 1) / 2);
}

}  // namespace hybrid
