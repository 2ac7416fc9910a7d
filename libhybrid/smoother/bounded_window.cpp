// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What leaves a window that is bounded by the place.
#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>

#include "libhybrid/discrete/inference.h"
#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/smoother/window.h"

namespace hybrid {
namespace {

/// States that leave in one update, at most, and at least once there are as many: a budget of time,
/// since they leave by one dense elimination.
constexpr std::size_t kBatch = 50;

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
    if (handle.kind == FactorKind::kHybrid) {
      const std::vector<Key>& keys = graph.hybrid().at(handle)->keys();
      held.insert(keys.begin(), keys.end());
    } else if (const ContinuousFactor& factor = *graph.continuous().at(handle);
               dynamic_cast<const LinearPrior*>(&factor) == nullptr) {
      held.insert(factor.keys().begin(), factor.keys().end());
    }
  }
  bool needed = false;
  for (Key key : held) {
    if (is_state(key, smoother_.values().type(key))) continue;
    needed = newer[key]++ < window_.sightings || needed;
  }
  return needed;
}

/// The states to marginalise now, those that follow each other together, oldest first; none until
/// there is a batch of them.
std::vector<std::vector<Key>> WindowSmoother::surplus() {
  if (entered_ <= window_.complete || entered_ < look_again_) return {};
  std::unordered_map<Key, int> newer;
  std::vector<std::size_t> found;  // newest first
  for (std::size_t i = states_.size(); i-- > 0;) {
    const bool needed = is_needed(states_[i], newer);
    if (!needed && states_.size() - i > static_cast<std::size_t>(std::max(window_.sightings, 1)))
      found.push_back(i);
  }
  if (found.size() < kBatch) {
    look_again_ = entered_ + static_cast<int>(kBatch);
    return {};
  }
  std::vector<std::vector<Key>> runs;
  for (std::size_t n = 0; n < kBatch; ++n) {
    const std::size_t i = found[found.size() - 1 - n];
    if (n == 0 || found[found.size() - n] + 1 != i) runs.emplace_back();
    runs.back().push_back(states_[i]);
  }
  return runs;
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

/// Replaces the tables that tie fixed variables to others by what they say of those.
void WindowSmoother::hold(const Fixed& fixed, Delta& delta) const {
  const HybridGraph& graph = smoother_.graph();
  double constant = 0.0;
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
  for (Table& table : delta.discrete) {
    if (table.keys().empty()) table = Table({}, {table.costs()[0] + constant});
  }
}

void WindowSmoother::note_covariances(const std::vector<Key>& keys, const Eigen::MatrixXd& joint) {
  Eigen::Index at = 0;
  for (Key key : keys) {
    const int dim = past_.values.type(key).dim;
    past_covariances_[key] = joint.block(at, at, dim, dim);
    at += dim;
  }
}

const Eigen::MatrixXd* WindowSmoother::past_covariance(Key key) const {
  const auto it = past_covariances_.find(key);
  return it == past_covariances_.end() ? nullptr : &it->second;
}

}  // namespace hybrid
