// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What leaves a window that is bounded by the place.
#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "libhybrid/discrete/inference.h"
#include "libhybrid/factors/detail/linear_prior.h"
#include "libhybrid/smoother/detail/divergence.h"
#include "libhybrid/smoother/window.h"

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

}  // namespace

void WindowSmoother::enter_state(Key key) {
  states_.push_back(key);
  ++entered_;
}

void WindowSmoother::forget_states(const std::vector<Key>& keys) {
  const std::unordered_set<Key> gone(keys.begin(), keys.end());
  states_.erase(
      std::remove_if(states_.begin(), states_.end(), [&](Key key) { return gone.count(key) != 0; }),
      states_.end());
}

/// Whether a state is one of the newest that hold some variable; `newer` counts those that are
/// newer by the variable that they hold, and this one from now on.
bool WindowSmoother::is_needed(Key state, std::unordered_map<Key, int>& newer) const {
  const HybridGraph& graph = smoother_.graph();
  std::unordered_set<Key> held;
  for (Handle handle : smoother_.factors_of(state)) {
    if (is_prior(graph, handle)) continue;
    const std::vector<Key>& keys = held_by(graph, handle);
    held.insert(keys.begin(), keys.end());
  }
  bool needed = false;
  for (Key key : held) {
    if (is_state(key, smoother_.values().type(key))) continue;
    needed = newer[key]++ < window_.sightings || needed;
  }
  return needed;
}

/// The states to marginalise now, oldest first; none until there is a batch of them.
std::vector<WindowSmoother::Departure> WindowSmoother::surplus() {
  if (entered_ <= window_.complete || entered_ < look_again_) return {};
  std::unordered_map<Key, int> newer;
  std::vector<std::size_t> found;  // newest first
  for (std::size_t i = states_.size(); i-- > 0;) {
    const bool needed = is_needed(states_[i], newer) || anchors_.count(states_[i]) != 0 ||
                        held_.count(states_[i]) != 0;
    if (!needed && states_.size() - i > static_cast<std::size_t>(std::max(window_.sightings, 1)))
      found.push_back(i);
  }
  if (found.size() < kStatesAtOnce) {
    look_again_ = entered_ + static_cast<int>(std::max(kStatesAtOnce, states_.size() / kLooks));
    return {};
  }
  std::vector<Departure> out;
  std::vector<Key> run;  // of states that follow each other
  for (std::size_t n = 0; n < kStatesAtOnce; ++n) {
    const std::size_t i = found[found.size() - 1 - n];
    run.push_back(states_[i]);
    if (n + 1 < kStatesAtOnce && found[found.size() - 2 - n] == i + 1) continue;
    for (Departure& going : split(run)) out.push_back(std::move(going));
    run.clear();
  }
  return out;
}

/// A run of states in parts that tie few variables together each, where the chain may be broken
/// between them.
std::vector<WindowSmoother::Departure> WindowSmoother::split(const std::vector<Key>& run) const {
  std::vector<Departure> parts(1);
  std::set<Key> tied;
  for (Key state : run) {
    const std::set<Key> own = tied_to(state);
    tied.insert(own.begin(), own.end());
    Departure& part = parts.back();
    if (tied.size() > static_cast<std::size_t>(window_.tied) && break_behind(part)) {
      parts.emplace_back();
      tied = own;
    }
    parts.back().keys.push_back(state);
  }
  return parts;
}

/// The variables other than states that the factors of a state hold.
std::set<Key> WindowSmoother::tied_to(Key state) const {
  std::set<Key> tied;
  for (Handle handle : smoother_.factors_of(state)) {
    for (Key key : held_by(smoother_.graph(), handle)) {
      if (!is_state(key, smoother_.values().type(key))) tied.insert(key);
    }
  }
  return tied;
}

/// Breaks the chain behind the last of some states, which is then their anchor, where that loses
/// little: leaves out what ties them to later states.
bool WindowSmoother::break_behind(Departure& going) const {
  if (going.keys.size() < 2) return false;
  const HybridGraph& graph = smoother_.graph();
  const auto last = std::find(states_.begin(), states_.end(), going.keys.back());
  const std::set<Key> later(last + 1, states_.end());
  std::vector<Handle> breaks;
  std::vector<const ContinuousFactor*> factors;
  for (Key state : going.keys) {
    for (Handle handle : smoother_.factors_of(state)) {
      const std::vector<Key>& keys = held_by(graph, handle);
      const bool ties =
          std::any_of(keys.begin(), keys.end(), [&](Key key) { return later.count(key) != 0; });
      if (!ties || std::find(breaks.begin(), breaks.end(), handle) != breaks.end()) continue;
      if (is_prior(graph, handle)) return false;
      breaks.push_back(handle);
      const ContinuousFactor* factor =
          handle.kind == FactorKind::kHybrid
              ? graph.hybrid().at(handle)->given(smoother_.assignment()).factor
              : graph.continuous().at(handle).get();
      if (factor != nullptr) factors.push_back(factor);
    }
  }
  const double loss = divergence_without(
      factors, smoother_.values(),
      [this](const std::vector<Key>& keys) { return smoother_.joint_covariance(keys); });
  if (!(loss <= kMostLoss)) return false;
  going.loss = loss;
  going.breaks = std::move(breaks);
  going.anchor = going.keys.back();
  going.keys.pop_back();
  return true;
}

std::vector<Handle> WindowSmoother::priors_of(Key state) const {
  std::vector<Handle> priors;
  for (Handle handle : smoother_.factors_of(state)) {
    if (is_prior(smoother_.graph(), handle)) priors.push_back(handle);
  }
  return priors;
}

/// Makes the prior of a new anchor one with that of an earlier one that holds nearly the same
/// variables; the earlier anchor leaves.
void WindowSmoother::absorb(Key anchor, WindowReport& report) {
  const std::set<Key> own = tied_to(anchor);
  std::optional<Key> best;
  std::size_t fewest = own.size();  // that it does not hold
  for (Key other : anchors_) {
    if (other == anchor) continue;
    std::set<Key> all = tied_to(other);
    const std::size_t before = all.size();
    all.insert(own.begin(), own.end());
    if (all.size() > 2 * static_cast<std::size_t>(window_.tied)) continue;
    if (all.size() - before >= fewest) continue;
    fewest = all.size() - before;
    best = other;
  }
  if (!best) return;
  Departure going{{*best}};
  going.absorbed = priors_of(anchor);
  leave(going, report);
}

/// Those of some discrete variables that chose the components of factors which all go.
std::vector<Key> WindowSmoother::chosen_by(const std::vector<Handle>& factors,
                                           const std::vector<Key>& discrete) const {
  const HybridGraph& graph = smoother_.graph();
  std::vector<Key> chosen;
  for (Key key : discrete) {
    bool chooses = false, stays = false;
    for (Handle handle : holders_.at(key)) {
      if (handle.kind != FactorKind::kHybrid || !graph.contains(handle)) continue;
      stays = stays || std::find(factors.begin(), factors.end(), handle) == factors.end();
      const auto selectors = graph.hybrid().at(handle)->selectors();
      chooses = chooses || std::any_of(selectors.begin(), selectors.end(),
                                       [&](const DiscreteKey& own) { return own.key == key; });
    }
    if (chooses && !stays) chosen.push_back(key);
  }
  return chosen;
}

/// Fixes discrete variables at their values. The remaining joint density is then the conditional
/// one, whose Kullback-Leibler divergence from the joint density is -log p of the values.
WindowSmoother::Fixed WindowSmoother::fix(const std::vector<Key>& discrete) const {
  Fixed fixed;
  for (Key key : discrete) fixed.values.set(key, smoother_.assignment().at(key));
  for (Key key : discrete) {
    if (fixed.posterior.count(key) != 0) continue;
    const std::vector<const Table*> tables = smoother_.component(key);
    const DiscreteMarginals marginals = discrete_marginals(tables);
    std::vector<Table> conditioned;
    for (const Table* table : tables) conditioned.push_back(condition(*table, fixed.values));
    std::vector<const Table*> rest;
    for (const Table& table : conditioned) rest.push_back(&table);
    fixed.divergence += marginals.log_partition() - discrete_marginals(rest).log_partition();
    for (Key own : discrete) {
      if (!marginals.contains(own)) continue;
      const auto p = marginals.at(own);
      const int value = fixed.values.at(own);
      std::vector<double> costs;
      for (double share : p) costs.push_back(std::log(p[value]) - std::log(share));
      fixed.posterior[own] = Table({{own, static_cast<int>(p.size())}}, std::move(costs));
    }
  }
  return fixed;
}

/// Replaces the tables that tie fixed variables to others by what they say of those; what breaks
/// leave out counts in the objective as it is.
void WindowSmoother::hold(const Fixed& fixed, const std::vector<Handle>& breaks,
                          Delta& delta) const {
  const HybridGraph& graph = smoother_.graph();
  double constant = 0.0;
  for (Handle handle : breaks) {
    constant += handle.kind == FactorKind::kHybrid
                    ? graph.hybrid().at(handle)->cost(smoother_.values(), smoother_.assignment())
                    : graph.continuous().at(handle)->cost(smoother_.values()) +
                          graph.continuous().at(handle)->log_normalizer();
  }
  for (const auto& [key, table] : fixed.posterior) {
    for (Handle handle : holders_.at(key)) {
      if (handle.kind != FactorKind::kDiscrete || !graph.contains(handle)) continue;
      const Table& tie = graph.discrete().at(handle);
      const bool counted =
          std::find(delta.remove.begin(), delta.remove.end(), handle) != delta.remove.end();
      if (tie.keys().size() < 2 || counted) continue;
      delta.remove.push_back(handle);
      Table left = condition(tie, fixed.values);
      if (left.keys().empty()) {
        constant += left.costs()[0];
      } else {
        delta.discrete.push_back(std::move(left));
      }
    }
  }
  add_constant(constant, delta);
}

Values WindowSmoother::past_states() const {
  return past_states_.at(smoother_.values(), past_covariances_);
}

/// The poses and points that a prior ties to each other.
std::vector<Key> WindowSmoother::tied_by(const Delta& delta) {
  std::vector<Key> tied;
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    const auto* prior = dynamic_cast<const LinearPrior*>(factor.get());
    if (prior == nullptr) continue;
    for (std::size_t i = 0; i < prior->keys().size(); ++i) {
      if (prior->located()[i]) tied.push_back(prior->keys()[i]);
    }
  }
  return tied;
}

void WindowSmoother::note_departure(const Departure& going, const Fixed& fixed,
                                    const Eigen::MatrixXd& joint, WindowReport& report) {
  forget_states(going.keys);
  Eigen::Index at = 0;
  for (Key key : going.keys) {
    const int dim = past_.values.type(key).dim;
    past_covariances_[key] = joint.block(at, at, dim, dim);
    at += dim;
    anchors_.erase(key);
  }
  if (going.anchor) {
    anchors_.insert(*going.anchor);
    ++report.breaks;
    ++breaks_;
  }
  report.divergence += fixed.divergence + going.loss;
  divergence_ += fixed.divergence + going.loss;
}

const Eigen::MatrixXd* WindowSmoother::past_covariance(Key key) const {
  const auto it = past_covariances_.find(key);
  return it == past_covariances_.end() ? nullptr : &it->second;
}

}  // namespace hybrid
