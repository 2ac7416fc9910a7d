// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/labelled_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

constexpr int kMaxModes = 50;
constexpr int kHalfWindow = 7;  ///< samples averaged for an initial labelling without labels

int last_column(const Options& options) {
  int last = options.label_column;
  for (const auto* list : {&options.angle_columns, &options.value_columns, &options.path_columns}) {
    for (int column : *list) last = std::max(last, column);
  }
  return last;
}

/// The label of each mode of a model learnt without labels: pairs modes and labels greedily by the
/// number of common frames in the training stretches.
std::vector<int> name_modes(const SwitchingModel& model,
                            const std::vector<LabelledSeries>& stretches) {
  const int n = model.modes();
  Eigen::MatrixXi together = Eigen::MatrixXi::Zero(n, n);
  for (const LabelledSeries& s : stretches) {
    const Labelling found = label(model, s.series);
    for (std::size_t t = 0; t < s.modes.size(); ++t) ++together(found.modes[t], s.modes[t]);
  }
  std::vector<int> names(n, 0);
  for (int k = 0; k < n; ++k) {
    int mode = 0, name = 0;
    together.maxCoeff(&mode, &name);
    names[mode] = name;
    together.row(mode).setConstant(-1);
    together.col(name).setConstant(-1);
  }
  return names;
}

SwitchingModel renamed(const SwitchingModel& model, const std::vector<int>& names) {
  SwitchingModel out = model;
  for (int i = 0; i < model.modes(); ++i) {
    out.motions[names[i]] = model.motions[i];
    out.chain.initial[names[i]] = model.chain.initial[i];
    for (int j = 0; j < model.modes(); ++j) {
      out.chain.transition(names[i], names[j]) = model.chain.transition(i, j);
    }
  }
  return out;
}

SwitchingModel learn(const std::vector<LabelledSeries>& stretches, int modes,
                     const Options& options) {
  LearnOptions learning;
  learning.order = options.order;
  if (!options.without_labels) return learn_from_labels(stretches, modes, learning);
  std::vector<Series> bare;
  for (const LabelledSeries& s : stretches) bare.push_back(s.series);
  const SwitchingModel guess = guess_by_level(bare, modes, kHalfWindow, learning);
  const SwitchingModel found = learn_without_labels(bare, guess, learning).model;
  return renamed(found, name_modes(found, stretches));
}

}  // namespace

LabelledTable read_table(const std::string& path, const Options& options) {
  TextReader file(path);
  LabelledTable table;
  const auto least = static_cast<std::size_t>(last_column(options));
  std::size_t columns = 0;
  while (const auto line = file.next()) {
    line->expect_same(columns, least, fmt::format("{} columns, the last one asked for", least));
    const auto label_column = static_cast<std::size_t>(options.label_column) - 1;
    table.labels.push_back(static_cast<int>(line->id(label_column, kMaxModes - 1)));
    table.rows.push_back(line->numbers(0, columns));
  }
  table.label_values = table.labels;
  sort_unique(table.label_values);
  for (int& label : table.labels) {
    label = static_cast<int>(
        std::lower_bound(table.label_values.begin(), table.label_values.end(), label) -
        table.label_values.begin());
  }
  const int fewest = options.folds * (options.order + 2);
  if (table.size() < fewest) {
    throw Error(fmt::format("{}: {} rows are too few for {} folds and order {}; at least {}", path,
                            table.size(), options.folds, options.order, fewest));
  }
  return table;
}

Series series_of(const LabelledTable& table, int first, int last, const Options& options) {
  const auto angles = static_cast<int>(options.angle_columns.size());
  const auto values = static_cast<int>(options.value_columns.size());
  if (angles + values == 0) throw Error("no column is chosen: give --angle-columns or others");
  Series series(angles + values, last - first);
  for (int t = first; t < last; ++t) {
    const int from = std::max(t, first + 1);
    for (int i = 0; i < angles; ++i) {
      const int column = options.angle_columns[i];
      series(i, t - first) =
          std::remainder(table.at(from, column) - table.at(from - 1, column), 2.0 * M_PI);
    }
    for (int i = 0; i < values; ++i) {
      series(angles + i, t - first) = table.at(t, options.value_columns[i]);
    }
  }
  return series;
}

FoldedLabels label_folds(const LabelledTable& table, const Options& options) {
  FoldedLabels out;
  out.probabilities.resize(table.modes(), table.size());
  const auto begin = [&](int fold) { return fold * table.size() / options.folds; };
  const auto stretch = [&](int first, int last) {
    return LabelledSeries{series_of(table, first, last, options),
                          {table.labels.begin() + first, table.labels.begin() + last}};
  };
  for (int fold = 0; fold < options.folds; ++fold) {
    const int first = begin(fold), last = begin(fold + 1);
    std::vector<LabelledSeries> others;
    if (first > 0) others.push_back(stretch(0, first));
    if (last < table.size()) others.push_back(stretch(last, table.size()));
    out.models.push_back(learn(others, table.modes(), options));
    const Labelling found = label(out.models.back(), series_of(table, first, last, options));
    int right = 0;
    for (int t = first; t < last; ++t) {
      right += found.modes[t - first] == table.labels[t];
      out.folds.push_back(fold);
      out.modes.push_back(found.modes[t - first]);
      out.probabilities.col(t) = found.probabilities.col(t - first);
    }
    out.accuracies.push_back(static_cast<double>(right) / (last - first));
  }
  return out;
}

}  // namespace hybrid
