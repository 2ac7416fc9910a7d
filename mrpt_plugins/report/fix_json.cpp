// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/fix_json.h"

#include <array>
#include <nlohmann/json.hpp>

#include "mrpt_plugins/report/columns.h"

namespace hybrid {

nlohmann::ordered_json fixes_json(const MapResult& result, std::size_t most) {
  constexpr std::size_t kNotUsed = 3;
  const auto kind = [](const FixEstimate& fix) {
    return fix.mode ? static_cast<std::size_t>(*fix.mode) : kNotUsed;
  };
  std::array<std::size_t, kNotUsed + 1> counts{}, seen{};
  for (const FixEstimate& fix : result.fixes) ++counts[kind(fix)];
  nlohmann::ordered_json out = empty_columns({"k", "x", "y", "ax", "ay", "mode", "p"});
  out["counts"] = counts;
  for (const FixEstimate& fix : result.fixes) {
    const std::size_t every = 1 + counts[kind(fix)] / (most + 1);
    if (!result.datum || seen[kind(fix)]++ % every != 0) continue;
    out["k"].push_back(fix.keyframe);
    out["x"].push_back(decimals(fix.measured.x()));
    out["y"].push_back(decimals(fix.measured.y()));
    out["ax"].push_back(decimals(fix.antenna.x()));
    out["ay"].push_back(decimals(fix.antenna.y()));
    out["mode"].push_back(kind(fix));
    const auto& p = fix.probabilities;
    const bool is_known = p[0] + p[1] + p[2] > 0;
    out["p"].push_back(is_known ? decimals(std::vector<double>(p.begin(), p.end()), 3)
                                : nlohmann::ordered_json::array());
  }
  return out;
}

}  // namespace hybrid
