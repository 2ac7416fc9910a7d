// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/health/detail/run_facts.h"
#include "mrpt_plugins/health/fix_figures.h"

namespace hybrid {
namespace {

constexpr std::size_t kFewestFixes = 30;
/// One in a hundred is expected, and a fifth of wrong ones makes a map wrong.
constexpr UpperLimits kFalseLimits{0.05, 0.2};
/// A tenth of the time is expected. Where it is most of the time, it is the map that may be off.
constexpr UpperLimits kBiasedLimits{0.25, 0.5};
constexpr double kMostInterval = 60;  // s, after which an error is forgotten

/// The robots of keyframes; 0 where there is but one.
std::map<std::size_t, std::size_t> robots_of(const MapResult& result) {
  std::map<std::size_t, std::size_t> out;
  for (std::size_t r = 0; r < result.robots.size(); ++r) {
    for (const std::size_t k : result.robots[r].keyframes) out[k] = r;
  }
  return out;
}

/// The newest fix of a receiver that is not false.
struct Newest {
  double time = 0;
  bool is_biased = false;
  double run = 0;  // how long it has been biased [s]
};

/// Takes in the next fix of a receiver; `biased_time` and `whole` are sums [s].
void follow(std::optional<Newest>& newest, double time, bool is_biased, double& biased_time,
            double& whole, FixFigures& out) {
  const double since = newest ? time - newest->time : -1;
  const bool is_known = since >= 0 && since <= kMostInterval;
  const bool was_biased = is_known && newest->is_biased;
  const double biased = is_known ? since * (int{is_biased} + int{was_biased}) / 2 : 0;
  if (is_known) whole += since;
  biased_time += biased;
  if (is_biased && !was_biased) ++out.bias_runs;
  const double run = biased + (was_biased ? newest->run : 0);
  out.longest_bias = std::max(out.longest_bias, run);
  newest = Newest{time, is_biased, run};
}

/// How many fixes are false, and of which receiver most are.
std::string wrong_fixes(const FixFigures& fixes) {
  std::string out = fmt::format("{} of {} fixes were taken for false", fixes.wrong, fixes.used);
  const auto most =
      std::max_element(fixes.wrong_of.begin(), fixes.wrong_of.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (fixes.wrong_of.size() > 1 && fixes.wrong > 0) {
    out += fmt::format(", {} of them of receiver '{}'", most->second, most->first);
  }
  return out + '.';
}

bool are_judged(const FixFigures& fixes) {
  return fixes.used >= kFewestFixes && fixes.asks_modes;
}

HealthEntry fix_entry(const char* name, double value, const UpperLimits& limits,
                      const FixFigures& fixes, const std::string& sentence, const char* knob) {
  HealthEntry entry = judged_entry(name, value, limits, sentence, knob);
  entry.is_optional = true;
  if (are_judged(fixes)) return entry;
  entry.knob.clear();
  entry.value = std::numeric_limits<double>::quiet_NaN();
  entry.verdict = HealthVerdict::kNotJudged;
  entry.sentence = fixes.used < kFewestFixes
                       ? fmt::format("{} of {} fixes are in the map, too few to judge by.",
                                     fixes.used, fixes.count)
                       : "Fixes were taken without modes ([Fixes] modes).";
  return entry;
}

}  // namespace

FixFigures fix_figures(const MapResult& result) {
  const std::map<std::size_t, std::size_t> robots = robots_of(result);
  std::map<std::pair<std::size_t, std::string>, std::optional<Newest>> newest;  // by receiver
  FixFigures out;
  double biased_time = 0, whole = 0;
  for (const FixEstimate& fix : result.fixes) {
    ++out.count;
    if (!fix.mode) continue;
    ++out.used;
    out.wrong_of[fix.sensor] += *fix.mode == FixMode::kFalse ? 1 : 0;
    const auto& p = fix.probabilities;
    if (*fix.mode != FixMode::kGood || p[0] + p[1] + p[2] > 0) out.asks_modes = true;
    if (*fix.mode == FixMode::kFalse) {
      ++out.wrong;
      continue;
    }
    const bool is_biased = *fix.mode == FixMode::kBiased;
    ++(is_biased ? out.biased : out.good);
    const auto robot = robots.find(fix.keyframe);
    const std::size_t number = robot == robots.end() ? 0 : robot->second;
    follow(newest[{number, fix.sensor}], fix.time, is_biased, biased_time, whole, out);
  }
  if (whole > 0) out.bias_share = biased_time / whole;
  return out;
}

HealthVerdict verdict_on_fixes(const FixFigures& fixes) {
  if (!are_judged(fixes)) return HealthVerdict::kNotJudged;
  return std::max(judge(fixes.wrong_share(), kFalseLimits), judge(fixes.bias_share, kBiasedLimits));
}

void check_fixes(const RunFacts& facts, Health& health) {
  const FixFigures fixes = fix_figures(facts.run.result);
  if (fixes.count == 0) return;
  health.push_back(
      fix_entry("false fixes", fixes.wrong_share(), kFalseLimits, fixes, wrong_fixes(fixes),
                "clock of the receiver, and where its antenna is on the robot; the path, which "
                "other checks ask about; [Fixes] sigma, if all fixes scatter by more"));
  health.push_back(fix_entry(
      "biased fixes", fixes.bias_share, kBiasedLimits, fixes,
      fmt::format("Fixes were biased for {:.0f} % of the time, in {} run{}, the longest {:.0f} s.",
                  100 * fixes.bias_share, fixes.bias_runs, fixes.bias_runs == 1 ? "" : "s",
                  fixes.longest_bias),
      "what hides the sky, as houses and trees; [Fixes] sigma, if good fixes of this receiver err "
      "by more than it says"));
}

}  // namespace hybrid
