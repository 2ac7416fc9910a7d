// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/drawing/style.h"

namespace HYBRID_API hybrid {

/// Entries of a matrix that belong together, as (row, column).
struct MatrixLayer {
  std::string label;  ///< text in the legend
  Color color = palette::kEstimate;
  std::vector<std::pair<int, int>> entries;
};

/// One matrix, row 0 at the top. Later layers cover earlier ones.
struct MatrixPanel {
  std::string heading;
  int rows = 0;
  int columns = 0;
  std::string row_label, column_label;  ///< meaning of rows and columns
  std::vector<MatrixLayer> layers;
};

/// Non-zeros of matrices as dots, side by side. Every entry is drawn; where a dot must be larger
/// than an entry to be seen, the picture says so. Throws std::invalid_argument for an entry outside
/// its matrix or a matrix without rows or columns.
Image matrix_image(const std::string& title, const std::string& subtitle,
                   const std::vector<MatrixPanel>& panels);

}  // namespace hybrid
