// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/linear/front.h"

namespace hybrid {

/// A run of consecutive rows of a symmetric matrix that stay consecutive in the front.
struct Run {
  int from;
  int to;
  int length;
};

/// Adds the lower triangle of a symmetric matrix, given by column pointers (column(c)[row]), to a
/// front.
template <class Column>
void scatter(const std::vector<Run>& runs, Column&& column, Front& front) {
  for (std::size_t j = 0; j < runs.size(); ++j) {
    const Run& cols = runs[j];
    for (int c = 0; c < cols.length; ++c) {
      const double* source = column(cols.from + c);
      double* target = front.column(cols.to + c);
      for (int r = c; r < cols.length; ++r) target[cols.to + r] += source[cols.from + r];
      for (std::size_t i = j + 1; i < runs.size(); ++i) {
        const Run& rows = runs[i];
        const double* s = source + rows.from;
        if (rows.to > cols.to) {
          double* t = target + rows.to;
          for (int r = 0; r < rows.length; ++r) t[r] += s[r];
        } else {
          for (int r = 0; r < rows.length; ++r) front(cols.to + c, rows.to + r) += s[r];
        }
      }
    }
  }
}

/// Appends a run, or lengthens the last one if the new rows follow it in the front.
inline void append_run(std::vector<Run>& runs, int from, int to, int length) {
  if (!runs.empty() && runs.back().to + runs.back().length == to) {
    runs.back().length += length;
  } else {
    runs.push_back({from, to, length});
  }
}

}  // namespace hybrid
