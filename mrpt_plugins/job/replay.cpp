// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/replay.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/job/detail/attempt.h"
#include "mrpt_plugins/session/remedies.h"

namespace hybrid {
namespace {

constexpr int kMostMeasurements = 4;  // of the noise, each with a map

/// Where landmarks are not found again, or mapped twice, which detection is of which landmark was
/// decided finer than could be told. Landmarks get an extent: the least with which what was bad is
/// not doubtful any more, or else with which it is least. No check may be bad that is clearly worse
/// than that of the `first` map. Each of the requests is coarsened in turn.
void map_coarsely(const std::vector<ReplayRequest>& requests, const Health& first,
                  const Watchers& watchers, std::chrono::steady_clock::time_point start,
                  ReplayOutcome& outcome) {
  const char* check = too_fine(outcome.summary.health);
  if (check == nullptr) return;
  const auto better = [&](const Health& a, const Health& b) {
    return is_better_by(check, a, b) && !has_spoilt(a, first);
  };
  const Summary fine = outcome.summary;
  for (const ReplayRequest& request : requests) {
    for (const ReplayRequest& coarse : coarser(request, fine)) {
      Attempt next =
          attempt(coarse, watchers, start, {&outcome.summary.health, better, false, false});
      if (next.outcome.signal != 0) outcome.signal = next.outcome.signal;
      if (next.is_written) outcome = std::move(next.outcome);
      if (outcome.signal != 0 || excess(outcome.summary.health, check) <= 1) return;
    }
  }
}

/// The requests to coarsen: that of the map which was taken and, if it has settings that a map told
/// whose associations may have been wrong, the one without these.
std::vector<ReplayRequest> to_coarsen(const ReplayRequest& request, const ReplayRequest& taken) {
  const ReplayRequest measured = Remedies().apply(request);
  if (taken.settings == request.settings || taken.settings == measured.settings) return {taken};
  return {taken, measured};
}

/// Maps logs whose map is bad again, with what they and that map tell of their noise, and takes an
/// outcome that is better. A doubtful map is made again where sign, clock or mounting of a sensor,
/// or what ids are, is not as stated. Returns the request of the map that is taken.
ReplayRequest map_as_measured(const ReplayRequest& request, const Watchers& watchers,
                              std::chrono::steady_clock::time_point start, ReplayOutcome& outcome) {
  Health health = outcome.summary.health;
  const IniFile::Settings configuration = outcome.summary.provenance.configuration;
  const bool in_doubt = worst(health) == HealthVerdict::kDoubtful;
  Remedies remedies;
  ReplayRequest taken = request;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const auto factors = remedies.factors;
    const bool changed = remedies.add(health, configuration);
    const bool again =
        worst(health) == HealthVerdict::kBad ? round == 0 || changed : in_doubt && round == 0;
    if (!again) return taken;
    ReplayRequest measured = remedies.apply(request);
    Attempt next = attempt(measured, watchers, start,
                           {&outcome.summary.health, is_better, !changed, in_doubt});
    if (!next.is_written && next.outcome.signal != 0) {
      outcome.signal = next.outcome.signal;
      return taken;
    }
    const Health& made = next.outcome.summary.health;
    const bool calibrated_in_vain =
        remedies.calibrates && (!next.is_written || worst(made) == HealthVerdict::kBad);
    if (calibrated_in_vain) {  // what the map before says holds still
      remedies.calibrates = false;
      remedies.factors = factors;
    } else {
      health = made;
    }
    if (next.is_written) {
      outcome = std::move(next.outcome);
      taken = std::move(measured);
    }
  }
  return taken;
}

}  // namespace

ReplayOutcome replay(const ReplayRequest& request,
                     const std::function<void(const ReplayProgress&)>& progress,
                     const std::function<void(const ReplayOutcome&)>& published) {
  const auto start = std::chrono::steady_clock::now();
  const Watchers watchers{progress, published};
  Attempt first = attempt(request, watchers, start, {});
  if (!first.may_measure) return std::move(first.outcome);
  try {
    const Health health = first.outcome.summary.health;
    const ReplayRequest taken = map_as_measured(request, watchers, start, first.outcome);
    if (first.outcome.signal == 0) {
      map_coarsely(to_coarsen(request, taken), health, watchers, start, first.outcome);
    }
  } catch (const Interrupted& e) {
    first.outcome.signal = e.signal();
  } catch (const Error& e) {
    first.outcome.summary.warnings.push_back(
        fmt::format("the log was not mapped again with its noise measured: {}", e.what()));
  }
  return std::move(first.outcome);
}

}  // namespace hybrid
