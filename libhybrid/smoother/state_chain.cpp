// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/state_chain.h"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/smoother/detail/divergence.h"

namespace hybrid {
namespace {

/// States that leave in one update, at most, and at least once there are as many: a budget of time,
/// since they leave by one dense elimination.
constexpr std::size_t kStatesAtOnce = 50;

/// How often a state is looked at, on average, while as many others enter as there are: a look at
/// all of them in every update would cost more the larger the place.
constexpr std::size_t kLooks = 16;

/// Divergence [nat] from which on the chain of states is not broken, however much is tied together:
/// the estimate moves by a standard deviation or so in some direction.
constexpr double kMostLoss = 1.0;

bool is_prior(const HybridGraph& graph, Handle handle) {
  return handle.kind == FactorKind::kContinuous &&
         dynamic_cast<const LinearPrior*>(graph.continuous().at(handle).get()) != nullptr;
}

const std::vector<Key>& held_by(const HybridGraph& graph, Handle handle) {
  return handle.kind == FactorKind::kHybrid ? graph.hybrid().at(handle)->keys()
                                            : graph.continuous().at(handle)->keys();
}

/// The variables that the factors of a state hold, the state among them.
std::set<Key> neighbours(Key state, const IncrementalSmoother& smoother) {
  std::set<Key> all;
  for (Handle handle : smoother.factors_of(state)) {
    const std::vector<Key>& keys = held_by(smoother.graph(), handle);
    all.insert(keys.begin(), keys.end());
  }
  return all;
}

/// Whether no factor ties a state to a newer one: the next motion hangs on it, if one comes.
bool ends_chain(Key state, const IncrementalSmoother& smoother,
                const std::unordered_set<Key>& newer) {
  const std::set<Key> near = neighbours(state, smoother);
  return std::none_of(near.begin(), near.end(), [&](Key key) { return newer.count(key) != 0; });
}

/// Appends a state to the run of which a factor ties it to the last one, or to a run of its own:
/// what follows each other leaves together, what does not would tie two places.
void append(Key state, const IncrementalSmoother& smoother, std::vector<std::vector<Key>>& runs) {
  const std::set<Key> near = neighbours(state, smoother);
  const auto run = std::find_if(runs.begin(), runs.end(), [&](const std::vector<Key>& some) {
    return near.count(some.back()) != 0;
  });
  if (run == runs.end()) {
    runs.push_back({state});
  } else {
    run->push_back(state);
  }
}

}  // namespace

void StateChain::forget(const std::vector<Key>& keys) {
  if (keys.empty()) return;
  const std::unordered_set<Key> gone(keys.begin(), keys.end());
  states_.erase(
      std::remove_if(states_.begin(), states_.end(), [&](Key key) { return gone.count(key) != 0; }),
      states_.end());
}

void StateChain::leave(const Departure& gone) {
  forget(gone.keys);
  for (Key key : gone.keys) anchors_.erase(key);
  if (gone.anchor) anchors_.insert(*gone.anchor);
}

/// Whether a state is one of the newest that hold some variable; `newer` counts those that are
/// newer by the variable that they hold, and this one from now on.
bool StateChain::is_needed(Key state, const IncrementalSmoother& smoother,
                           std::unordered_map<Key, int>& newer) const {
  const HybridGraph& graph = smoother.graph();
  std::unordered_set<Key> held;
  for (Handle handle : smoother.factors_of(state)) {
    if (is_prior(graph, handle)) continue;
    const std::vector<Key>& keys = held_by(graph, handle);
    held.insert(keys.begin(), keys.end());
  }
  bool needed = false;
  for (Key key : held) {
    if (options_.is_state(key, smoother.values().type(key))) continue;
    needed = newer[key]++ < options_.sightings || needed;
  }
  return needed;
}

std::vector<Departure> StateChain::surplus(const IncrementalSmoother& smoother,
                                           const std::set<Key>& held) {
  if (entered_ <= options_.complete || entered_ < look_again_) return {};
  std::unordered_map<Key, int> newer;
  std::unordered_set<Key> newer_states;
  std::vector<std::size_t> found;  // newest first
  for (std::size_t i = states_.size(); i-- > 0;) {
    const bool needed = is_needed(states_[i], smoother, newer) || anchors_.count(states_[i]) != 0 ||
                        held.count(states_[i]) != 0 ||
                        ends_chain(states_[i], smoother, newer_states);
    newer_states.insert(states_[i]);
    if (!needed && states_.size() - i > static_cast<std::size_t>(std::max(options_.sightings, 1)))
      found.push_back(i);
  }
  if (found.size() < kStatesAtOnce) {
    look_again_ = entered_ + static_cast<int>(std::max(kStatesAtOnce, states_.size() / kLooks));
    return {};
  }
  std::vector<std::vector<Key>> runs;
  for (std::size_t n = 0; n < kStatesAtOnce; ++n) {
    append(states_[found[found.size() - 1 - n]], smoother, runs);
  }
  std::vector<Departure> out;
  for (const std::vector<Key>& run : runs) {
    for (Departure& going : split(run, smoother)) out.push_back(std::move(going));
  }
  return out;
}

/// A run of states in parts that tie few variables together each, where the chain may be broken
/// between them.
std::vector<Departure> StateChain::split(const std::vector<Key>& run,
                                         const IncrementalSmoother& smoother) const {
  std::vector<Departure> parts(1);
  std::set<Key> tied;
  for (Key state : run) {
    const std::set<Key> own = tied_to(state, smoother);
    tied.insert(own.begin(), own.end());
    Departure& part = parts.back();
    if (tied.size() > static_cast<std::size_t>(options_.tied) && break_behind(part, smoother)) {
      parts.emplace_back();
      tied = own;
    }
    parts.back().keys.push_back(state);
  }
  return parts;
}

/// The variables other than states that the factors of a state hold.
std::set<Key> StateChain::tied_to(Key state, const IncrementalSmoother& smoother) const {
  std::set<Key> tied;
  for (Key key : neighbours(state, smoother)) {
    if (!options_.is_state(key, smoother.values().type(key))) tied.insert(key);
  }
  return tied;
}

/// Breaks the chain behind the last of some states, which is then their anchor, where that loses
/// little: leaves out what ties them to later states.
bool StateChain::break_behind(Departure& going, const IncrementalSmoother& smoother) const {
  if (going.keys.size() < 2) return false;
  const HybridGraph& graph = smoother.graph();
  const auto last = std::find(states_.begin(), states_.end(), going.keys.back());
  const std::set<Key> later(last + 1, states_.end());
  std::vector<Handle> breaks;
  std::vector<const ContinuousFactor*> factors;
  for (Key state : going.keys) {
    for (Handle handle : smoother.factors_of(state)) {
      const std::vector<Key>& keys = held_by(graph, handle);
      const bool ties =
          std::any_of(keys.begin(), keys.end(), [&](Key key) { return later.count(key) != 0; });
      if (!ties || std::find(breaks.begin(), breaks.end(), handle) != breaks.end()) continue;
      if (is_prior(graph, handle)) return false;
      breaks.push_back(handle);
      const ContinuousFactor* factor =
          handle.kind == FactorKind::kHybrid
              ? graph.hybrid().at(handle)->given(smoother.assignment()).factor
              : graph.continuous().at(handle).get();
      if (factor != nullptr) factors.push_back(factor);
    }
  }
  const double loss = divergence_without(
      factors, smoother.values(),
      [&](const std::vector<Key>& keys) { return smoother.joint_covariance(keys); });
  if (!(loss <= kMostLoss)) return false;
  going.loss = loss;
  going.breaks = std::move(breaks);
  going.anchor = going.keys.back();
  going.keys.pop_back();
  return true;
}

std::optional<Departure> StateChain::absorption(Key anchor,
                                                const IncrementalSmoother& smoother) const {
  const std::set<Key> own = tied_to(anchor, smoother);
  std::optional<Key> best;
  std::size_t fewest = own.size();  // that it does not hold
  for (Key other : anchors_) {
    if (other == anchor) continue;
    std::set<Key> all = tied_to(other, smoother);
    const std::size_t before = all.size();
    all.insert(own.begin(), own.end());
    if (all.size() > 2 * static_cast<std::size_t>(options_.tied)) continue;
    if (all.size() - before >= fewest) continue;
    fewest = all.size() - before;
    best = other;
  }
  if (!best) return std::nullopt;
  Departure going{{*best}};
  for (Handle handle : smoother.factors_of(anchor)) {
    if (is_prior(smoother.graph(), handle)) going.absorbed.push_back(handle);
  }
  return going;
}

}  // namespace hybrid
