// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/hybrid-switching/options.h"
#include "libhybrid/switching/learn.h"

namespace hybrid {

/// A labelled series as read from its file.
struct LabelledTable {
  std::vector<std::vector<double>> rows;
  std::vector<int> labels;        ///< of each row; a mode, which is a place in label_values
  std::vector<int> label_values;  ///< as written in the file, ascending, each once

  int modes() const { return static_cast<int>(label_values.size()); }
  int size() const { return static_cast<int>(rows.size()); }
  double at(int row, int column) const { return rows[row][column - 1]; }
};

/// Reads rows of numbers, all of one length; '%' and '#' begin comments. Throws Error that names
/// file, line and column for rows without the required columns, numbers that are not finite, and
/// labels other than 0, 1, ...
LabelledTable read_table(const std::string& path, const Options& options);

/// The series of rows first .. last - 1: the changes of the angles, wrapped, then the values. It
/// uses no other row: the first change is a copy of the second.
Series series_of(const LabelledTable& table, int first, int last, const Options& options);

/// Modes of a whole table, each fold labelled by a model learnt from the other folds.
struct FoldedLabels {
  std::vector<int> folds;  ///< by row
  std::vector<int> modes;
  Eigen::MatrixXd probabilities;   ///< one column per row of the table
  std::vector<double> accuracies;  ///< by fold
  std::vector<SwitchingModel> models;
};
FoldedLabels label_folds(const LabelledTable& table, const Options& options);

}  // namespace hybrid
