// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/health/agreement.h"
#include "mrpt_plugins/health/fix_figures.h"
#include "mrpt_plugins/health/unit_words.h"
#include "mrpt_plugins/job/detail/attempt.h"
#include "mrpt_plugins/rawlog/parsed_logs.h"
#include "mrpt_plugins/session/remedies.h"

namespace hybrid {
namespace {

constexpr int kMostMeasurements = 4;  // of the noise, each with a map
/// All further maps together may take so many times the work of the first, or else so much:
/// budgets.
constexpr double kMostWork = 10;
constexpr double kLeastWork = 3e6;  // linearised factors and eliminated variables, some seconds

/// Makes further maps of the logs after a first one, within the budget.
class Attempts {
 public:
  Attempts(const Watchers& watchers, std::chrono::steady_clock::time_point start,
           const Attempt& first)
      : watchers_(watchers),
        start_(start),
        settings_(first.request.settings),
        first_work_(first.work),
        left_(std::max(kMostWork * first.work, kLeastWork)) {
    add(first);
  }

  Attempt make(const ReplayRequest& request, Conditions conditions) {
    conditions.most_work = left_ / 2;  // leaves as much to those after it
    Attempt made = attempt(request, watchers_, start_, conditions);
    left_ -= made.work;
    measuring_is_in_vain_ = measuring_is_in_vain_ || made.measured_nothing;
    add(made);
    return made;
  }

  /// The first of these requests of which no map was made.
  std::optional<ReplayRequest> first_untried(const std::vector<ReplayRequest>& requests) const {
    const auto is_untried = [this](const ReplayRequest& request) {
      return tried_.count(in_effect(request)) == 0;
    };
    const auto found = std::find_if(requests.begin(), requests.end(), is_untried);
    return found == requests.end() ? std::nullopt : std::optional(*found);
  }

  /// All maps, the first one too.
  const std::vector<DrawSummary>& draws() const { return draws_; }

 private:
  /// The last value of each setting, of those that have an effect.
  std::map<std::string, std::string> in_effect(const ReplayRequest& request) const {
    std::map<std::string, std::string> out;
    for (const std::string& setting : request.settings) {
      const bool is_in_vain = measuring_is_in_vain_ && setting == kMeasuresNoise;
      const std::size_t end = setting.find('=');
      if (!is_in_vain) out[setting.substr(0, end)] = setting.substr(end);
    }
    return out;
  }

  void add(const Attempt& made) {
    tried_.insert(in_effect(made.request));
    DrawSummary draw;
    for (const std::string& setting : made.request.settings) {
      const bool is_given =
          std::find(settings_.begin(), settings_.end(), setting) != settings_.end();
      if (!is_given) draw.settings.push_back(setting);
    }
    const Health& health = made.outcome.summary.health;
    draw.agreement = agreement_values(health);
    if (!health.empty()) draw.health = worst(health);
    draw.work = first_work_ > 0 ? made.work / first_work_ : 1.0;
    draw.is_taken = made.is_written;
    for (DrawSummary& other : draws_) other.is_taken = other.is_taken && !draw.is_taken;
    draws_.push_back(std::move(draw));
  }

  const Watchers& watchers_;
  std::chrono::steady_clock::time_point start_;
  std::vector<std::string> settings_;
  double first_work_, left_;
  std::vector<DrawSummary> draws_;
  std::set<std::map<std::string, std::string>> tried_;
  bool measuring_is_in_vain_ = false;  // the logs are as they state
};

/// Takes another map if it is one; a signal that stopped it counts in any case. Returns whether to
/// go on.
bool take(Attempt next, Attempt& taken) {
  const int signal = next.outcome.signal;
  if (next.is_written) {
    taken = std::move(next);
  } else if (signal != 0) {
    taken.outcome.signal = signal;
  }
  return signal == 0;
}

/// Adds what is not among them yet.
void add_once(const std::vector<std::string>& more, std::vector<std::string>& warnings) {
  for (const std::string& text : more) {
    if (std::find(warnings.begin(), warnings.end(), text) == warnings.end()) {
      warnings.push_back(text);
    }
  }
}

/// Maps logs whose map is bad again, with what they and that map tell of their noise, and takes a
/// map that is better. A doubtful map is made again where sign, clock or mounting of a sensor, or
/// what ids are, is not as stated.
void map_as_measured(const ReplayRequest& request, Attempts& attempts, Attempt& taken) {
  Health health = taken.outcome.summary.health;
  const IniFile::Settings configuration = taken.outcome.summary.provenance.configuration;
  const bool in_doubt = worst(health) == HealthVerdict::kDoubtful;
  Remedies remedies;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const auto factors = remedies.factors;
    const bool changed = remedies.add(health, configuration);
    const bool again =
        worst(health) == HealthVerdict::kBad ? round == 0 || changed : in_doubt && round == 0;
    if (!again) return;
    Attempt next = attempts.make(remedies.apply(request), {&taken.outcome.summary.health, is_better,
                                                           !changed, in_doubt, taken.had_no_ids});
    const Health made = next.outcome.summary.health;
    const std::vector<std::string> units = unit_words(next.outcome.summary.calibration);
    const bool calibrated_in_vain =
        remedies.calibrates && (!next.is_written || worst(made) == HealthVerdict::kBad);
    const bool is_left_out = !next.is_written;
    if (!take(std::move(next), taken)) return;
    if (is_left_out) add_once(units, taken.outcome.summary.warnings);
    if (calibrated_in_vain) {  // what the map before says holds still
      remedies.calibrates = false;
      remedies.factors = factors;
    } else {
      health = made;
    }
  }
}

/// Whether no check of a map is bad, nor its agreement over time doubtful.
bool is_right(const Health& health) {
  return worst(health) < HealthVerdict::kBad && agreement_of(health) != HealthVerdict::kDoubtful;
}

/// Makes other maps of logs whose map is not right, until one is; they begin with the best so far,
/// or with the one that was taken before.
void draw(const ReplayRequest& request, Attempts& attempts, Attempt& taken) {
  const Summary first = taken.outcome.summary;
  const ReplayRequest before_draws = taken.request;
  while (taken.outcome.signal == 0 && !is_right(taken.outcome.summary.health)) {
    const auto other = attempts.first_untried(draws(request, {taken.request, before_draws}, first));
    if (!other) return;
    const Health before = taken.outcome.summary.health;
    take(attempts.make(*other, {&before, agrees_better}), taken);
  }
}

/// Makes another map, if it is asked for and was not tried, and keeps the one that agrees better.
void try_other(const std::optional<ReplayRequest>& asked, Attempts& attempts, Attempt& taken) {
  if (!asked || taken.outcome.signal != 0) return;
  const auto other = attempts.first_untried({*asked});
  if (!other) return;
  const Health before = taken.outcome.summary.health;
  take(attempts.make(*other, {&before, agrees_better}), taken);
}

/// Maps logs without their fixes where these may be what is wrong.
void map_without_fixes(Attempts& attempts, Attempt& taken) {
  try_other(without_fixes(taken.request, taken.outcome.summary), attempts, taken);
}

/// Adds all maps that were made to the summary of the one that was taken.
void tell_draws(const std::vector<DrawSummary>& draws, ReplayOutcome& outcome) {
  outcome.summary.draws = draws;
  try {
    amend_summary(outcome.folder, "draws", to_json(draws));
  } catch (const Error& e) {
    outcome.summary.warnings.push_back(e.what());
  }
}

}  // namespace

ReplayOutcome replay(const ReplayRequest& asked,
                     const std::function<void(const ReplayProgress&)>& progress,
                     const std::function<void(const ReplayOutcome&)>& published) {
  const auto start = std::chrono::steady_clock::now();
  ReplayRequest request = asked;
  request.parsed = std::make_shared<ParsedLogs>();
  const Watchers watchers{progress, published};
  Attempt taken = attempt(request, watchers, start, {});
  if (!taken.may_measure) return std::move(taken.outcome);
  Attempts attempts(watchers, start, taken);
  try {
    map_as_measured(request, attempts, taken);
    try_other(with_stated_noise(taken.request, taken.outcome.summary), attempts, taken);
    if (verdict_on_fixes(taken.outcome.summary.fixes) == HealthVerdict::kBad) {
      map_without_fixes(attempts, taken);
    }
    draw(request, attempts, taken);
    map_without_fixes(attempts, taken);
  } catch (const Interrupted& e) {
    taken.outcome.signal = e.signal();
  } catch (const Error& e) {
    taken.outcome.summary.warnings.push_back(
        fmt::format("the log was not mapped again with its noise measured: {}", e.what()));
  }
  if (attempts.draws().size() > 1) tell_draws(attempts.draws(), taken.outcome);
  return std::move(taken.outcome);
}

}  // namespace hybrid
