// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mode_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/evaluation/reliability.h"

namespace hybrid {
namespace {

/// What a fix is said to be; nothing where that is open, as the map has no place on earth.
std::optional<FixMode> judged_mode(const FixEstimate& fix) {
  const auto& p = fix.probabilities;
  const auto most = std::max_element(p.begin(), p.end());
  if (*most > 0) return static_cast<FixMode>(most - p.begin());
  if (!fix.mode && !fix.unused.empty()) return FixMode::kFalse;
  return fix.mode;
}

}  // namespace

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
    score.add(found, real);
  }
  return score;
}

FixScore score_fixes(std::vector<FixEstimate> fixes, const std::vector<TrueFix>& truth) {
  constexpr double kSameStamp = 1e-3;  // s
  std::stable_sort(fixes.begin(), fixes.end(),
                   [](const FixEstimate& a, const FixEstimate& b) { return a.time < b.time; });
  FixScore score;
  std::vector<ClassPrediction> predictions;
  auto row = truth.begin();
  for (const FixEstimate& fix : fixes) {
    while (row != truth.end() && row->time < fix.time - kSameStamp) ++row;
    if (row == truth.end()) break;
    if (row->time > fix.time + kSameStamp) continue;  // the truth lacks it
    const FixMode real = (row++)->mode;
    const std::optional<FixMode> found = judged_mode(fix);
    if (!found) continue;
    ++score.fixes;
    score.wrong.add(*found == FixMode::kFalse, real == FixMode::kFalse);
    score.biased.add(*found == FixMode::kBiased, real == FixMode::kBiased);
    const auto& p = fix.probabilities;
    if (p[0] + p[1] + p[2] > 0) predictions.push_back({{p[0], p[1], p[2]}, static_cast<int>(real)});
  }
  if (!predictions.empty()) score.calibration_error = calibration(predictions).expected_error;
  return score;
}

}  // namespace hybrid
