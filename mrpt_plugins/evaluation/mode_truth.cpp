// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/mode_truth.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

FixMode fix_mode_in(const TextRow& row, std::size_t i) {
  const auto* const found = std::find(kFixModes.begin(), kFixModes.end(), row[i]);
  if (found != kFixModes.end()) return static_cast<FixMode>(found - kFixModes.begin());
  row.fail(i, fmt::format("'{}' is no mode of a fix; write one of {}", row[i],
                          fmt::join(kFixModes, ", ")));
}

}  // namespace

std::vector<int> read_true_modes(const std::string& path) {
  constexpr std::int64_t kMostModes = 999999;
  std::vector<int> modes;
  TextReader text(path);
  while (const auto row = text.next()) {
    row->expect(1, "the number of a mode");
    modes.push_back(static_cast<int>(row->id(0, kMostModes)));
  }
  return modes;
}

std::vector<TrueFix> read_true_fixes(const std::string& path) {
  std::vector<TrueFix> truth;
  TextReader table(path);
  for (auto row = table.first_below("time"); row; row = table.next()) {
    row->expect(5, "time,mode,error_east,error_north,error_up");
    for (std::size_t i = 2; i < row->size(); ++i) row->coordinate(i);
    truth.push_back({row->time(0), fix_mode_in(*row, 1)});
  }
  if (truth.empty()) table.fail("no row of a fix below the titles");
  std::stable_sort(truth.begin(), truth.end(),
                   [](const TrueFix& a, const TrueFix& b) { return a.time < b.time; });
  return truth;
}

}  // namespace hybrid
