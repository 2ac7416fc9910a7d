// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Updates of the map by contributions of plugins.

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostWarnings = 20;

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void merge(Delta& into, const Delta& from) {
  append(into.continuous, from.continuous);
  append(into.discrete, from.discrete);
  append(into.hybrid, from.hybrid);
  append(into.remove, from.remove);
  append(into.remove_values, from.remove_values);
  for (const Key key : from.values.keys()) {
    into.values.insert(key, from.values.type(key), from.values.data(key));
  }
  for (const auto& [key, value] : from.assignment) into.assignment.set(key, value);
}

/// The result of a call, whose wall time is added to `ms`.
template <class Call>
auto timed(double& ms, Call&& call) {
  const auto start = std::chrono::steady_clock::now();
  auto result = call();
  ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

/// What each plugin says when it is asked; one that throws, or contradicts the landmarks of the
/// map, says nothing.
std::vector<Contribution> Mapper::ask(const std::function<Contribution(std::size_t)>& question) {
  std::vector<Contribution> contributions(plugins_.size());
  for (std::size_t p = 0; p < plugins_.size(); ++p) {
    const std::size_t changes = landmarks_.changes();
    try {
      contributions[p] = timed(plugin_ms_, [&] { return question(p); });
      for (const auto& [reason, count] : contributions[p].dropped) dropped_[reason] += count;
      enter(contributions[p], landmarks_);
    } catch (const std::bad_alloc&) {
      landmarks_.roll_back();
      for (std::size_t asked = 0; asked <= p; ++asked) plugins_[asked]->refused();
      throw;
    } catch (const SettingsError&) {
      throw;
    } catch (const std::exception& e) {
      landmarks_.roll_back(changes);
      contributions[p] = {};
      refuse(p, e.what());
    } catch (...) {
      landmarks_.roll_back(changes);
      contributions[p] = {};
      refuse(p, fmt::format("plugin {} has thrown what is no std::exception",
                            plugins_[p]->GetRuntimeClass()->className));
    }
  }
  return contributions;
}

/// Counts an unusable measurement; the first few are reported in full.
void Mapper::note(const std::string& reason, const std::string& what) {
  ++dropped_[reason];
  if (warnings_.size() < kMostWarnings) {
    warnings_.push_back(fmt::format("step {} of the log: {}: {}", row_, reason, what));
  }
}

void Mapper::refuse(std::size_t plugin, const std::string& reason) {
  ++refusals_;
  plugins_[plugin]->refused();
  if (events_) events_->push_back({{}, {}, {}, {}, {}, reason});
  note("observations dropped: not usable", reason);
}

/// Nothing of the contributions that are not answered yet is in the map: those of the plugins from
/// one on.
void Mapper::refuse_from(std::size_t plugin) {
  landmarks_.roll_back();
  for (; plugin < plugins_.size(); ++plugin) plugins_[plugin]->refused();
}

/// One update with the motion (`delta`) and all contributions. If it is refused, or one of them is
/// on trial, the motion alone is added, and then the contributions one by one, without those that
/// are refused again or turned down.
BackendReport Mapper::update(const Delta& delta, const std::vector<Contribution>& contributions) {
  Delta all = delta;
  std::array<std::size_t, 3> first = {delta.continuous.size(), delta.discrete.size(),
                                      delta.hybrid.size()};
  const auto any = [&](auto&& is) {
    return std::any_of(contributions.begin(), contributions.end(), is);
  };
  if (any([](const Contribution& c) { return c.allowed_rise.has_value(); })) {
    landmarks_.roll_back();
    return update_one_by_one(delta, contributions);
  }
  const bool settles = any([](const Contribution& c) { return c.settle; });
  BackendReport report;
  try {
    for (const Contribution& contribution : contributions) merge(all, contribution.delta);
    report = backend_->update(all);
  } catch (const std::bad_alloc&) {
    refuse_from(0);
    throw;
  } catch (const std::exception&) {
    landmarks_.roll_back();
    return update_one_by_one(delta, contributions);
  }
  landmarks_.commit();
  keep(report);
  for (const Contribution& contribution : contributions) keep(contribution);
  note_start(delta, report);
  if (settles) add_work(report, solve(&Backend::settle));
  for (std::size_t p = 0; p < contributions.size(); ++p) tell(p, contributions[p], report, first);
  count(report);
  return report;
}

BackendReport Mapper::update_one_by_one(const Delta& delta,
                                        const std::vector<Contribution>& contributions) {
  BackendReport report;
  report.objective_after = objective_;
  if (!delta.continuous.empty()) {  // a revision brings no motion
    try {
      report = backend_->update(delta);
    } catch (...) {
      refuse_from(0);
      throw;
    }
    keep(report);
    note_start(delta, report);
    count(report);
  }
  for (std::size_t p = 0; p < contributions.size(); ++p) {
    const Contribution& own = contributions[p];
    if (own.empty()) {
      std::array<std::size_t, 3> none{};
      tell(p, own, report, none);
      continue;
    }
    try {
      enter(own, landmarks_);
      BackendReport one = own.allowed_rise
                              ? backend_->propose({own.delta, *own.allowed_rise, own.moved})
                              : backend_->update(own.delta);
      if (one.status == UpdateReport::Status::kTurnedDown) {
        landmarks_.roll_back();
        plugins_[p]->refused();
        keep_turned_down(own);
      } else {
        landmarks_.commit();
        keep(one);
        keep(own);
        if (own.settle) add_work(one, solve(&Backend::settle));
        std::array<std::size_t, 3> first{};
        tell(p, own, one, first);
      }
      count(one);
      add_work(report, one);
    } catch (const std::bad_alloc&) {
      refuse_from(p);
      throw;
    } catch (const std::exception& e) {
      landmarks_.roll_back();
      refuse(p, e.what());
    }
  }
  return report;
}

/// Tells a plugin the outcome of its contribution. `first` are the positions of its handles in the
/// report by kind of factor; they advance behind them.
void Mapper::tell(std::size_t plugin, const Contribution& contribution, const BackendReport& report,
                  std::array<std::size_t, 3>& first) {
  const auto next = [](const std::vector<Handle>& all, std::size_t count, std::size_t& from) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(from);
    from += count;
    return std::vector<Handle>(begin, begin + static_cast<std::ptrdiff_t>(count));
  };
  const Delta& own = contribution.delta;
  const AddedHandles& all = report.handles;
  Outcome outcome{{}, objective_, report.objective_after, report.exact};
  outcome.handles.continuous = next(all.continuous, own.continuous.size(), first[0]);
  outcome.handles.discrete = next(all.discrete, own.discrete.size(), first[1]);
  outcome.handles.hybrid = next(all.hybrid, own.hybrid.size(), first[2]);
  plugins_[plugin]->applied(outcome);
}

void Mapper::count_work(const BackendReport& report) {
  work_ += report.relinearized + report.eliminated;
}

void Mapper::count(const BackendReport& report) {
  count_work(report);
  ++updates_;
  if (!report.exact) ++updates_by_local_search_;
  objective_ = report.objective_after;
}

/// Solves by one of the back-end's ways, all of whose time counts; if that fails, the estimate
/// stays as it is.
BackendReport Mapper::solve(BackendReport (Backend::*way)()) try {
  const auto start = std::chrono::steady_clock::now();
  BackendReport report = (backend_.get()->*way)();
  report.seconds = seconds_since(start);
  count_work(report);
  keep(report);
  return report;
} catch (const Error& e) {
  note("solution to convergence dropped: not possible", e.what());
  BackendReport report;
  report.objective_after = objective_;
  return report;
}

/// Records a change by the back-end, if events are kept.
void Mapper::keep(const BackendReport& report) {
  if (events_) events_->push_back({report.objectives, report.flipped, {}, {}, {}, {}});
}

/// Counts the factors of a contribution, and adds its reasons to the last recorded change.
void Mapper::keep(const Contribution& contribution) {
  const Delta& own = contribution.delta;
  const std::size_t added = own.continuous.size() + own.discrete.size() + own.hybrid.size();
  measurements_ = std::max(measurements_ + added, own.remove.size()) - own.remove.size();
  if (!events_) return;
  MapChange& change = events_->back();
  for (const Landmark& landmark : contribution.landmarks) change.born.push_back(landmark.id);
  append(change.forgotten, contribution.forgotten);
  append(change.why.decisions, contribution.events.decisions);
  append(change.why.sightings, contribution.events.sightings);
  append(change.why.associations, contribution.events.associations);
  append(change.why.merges, contribution.events.merges);
  if (change.why.class_prior.empty()) change.why.class_prior = contribution.events.class_prior;
}

/// Records what a contribution that was turned down would have made one.
void Mapper::keep_turned_down(const Contribution& contribution) {
  if (!events_) return;
  MapChange change;
  change.why.merges = contribution.events.merges;
  for (MergeEvent& event : change.why.merges) event.undone = true;
  events_->push_back(std::move(change));
}

std::vector<MapChange> Mapper::take_events() {
  std::vector<MapChange> out;
  if (events_) out.swap(*events_);
  return out;
}

/// Applies revisions of the plugins until there are none. Stops once a revision is refused.
BackendReport Mapper::revise(bool concluding) {
  BackendReport work;
  work.objective_after = objective_;
  const std::size_t refusals = refusals_;
  for (bool again = true; again && refusals_ == refusals;) {
    if (work_ > most_work_) throw TooMuchWork();
    const MapView map = view();
    const std::vector<Contribution> contributions = ask([&](std::size_t p) {
      return concluding ? plugins_[p]->conclude(map) : plugins_[p]->revise(map);
    });
    again = std::any_of(contributions.begin(), contributions.end(),
                        [](const Contribution& c) { return !c.empty(); });
    if (again) add_work(work, update({}, contributions));
  }
  landmarks_.commit();
  return work;
}

}  // namespace hybrid
