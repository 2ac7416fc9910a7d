// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/mode_truth.h"

#include "libhybrid/io/text_reader.h"

namespace hybrid {

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

}  // namespace hybrid
