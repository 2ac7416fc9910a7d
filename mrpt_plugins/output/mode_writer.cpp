// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mode_writer.h"

#include <fmt/format.h>

#include <iterator>

#include "libhybrid/core/error.h"

namespace hybrid {

std::string modes_csv(const MapResult& result) {
  std::string text = "keyframe,time,mode";
  for (const std::string& name : result.mode_names) text += fmt::format(",p_{}", name);
  text += '\n';
  for (std::size_t i = 0; i < result.motion_modes.size(); ++i) {
    const int mode = result.motion_modes[i];
    if (mode < 0) continue;
    fmt::format_to(std::back_inserter(text), "{},{},{}", i, result.trajectory[i].time,
                   result.mode_names[static_cast<std::size_t>(mode)]);
    const std::vector<double>& p = result.mode_probabilities[i];
    for (std::size_t m = 0; m < result.mode_names.size(); ++m) {
      text += p.empty() ? "," : fmt::format(",{:.6g}", p[m]);
    }
    text += '\n';
  }
  return text;
}

ModeScore score_modes(const MapResult& result, const std::vector<std::size_t>& log_rows,
                      const std::vector<int>& truth) {
  ModeScore score;
  for (std::size_t i = 0; i < result.motion_modes.size(); ++i) {
    if (result.motion_modes[i] < 0) continue;
    if (log_rows[i] >= truth.size()) {
      throw Error(fmt::format("the true modes have {} rows, but the log has a frame for row {}",
                              truth.size(), log_rows[i]));
    }
    const bool found = result.motion_modes[i] > 0, real = truth[log_rows[i]] > 0;
    ++score.motions;
    score.found += found;
    score.real += real;
    score.both += found && real;
  }
  return score;
}

}  // namespace hybrid
