// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// At most `most` of some values, evenly chosen in their order.
template <class T>
std::vector<T> evenly_chosen(const std::vector<T>& values, std::size_t most) {
  if (values.size() <= most) return values;
  std::vector<T> out;
  out.reserve(most);
  for (std::size_t i = 0; i < most; ++i) out.push_back(values[i * values.size() / most]);
  return out;
}

}  // namespace hybrid
