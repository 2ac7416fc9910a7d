// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/delayed_decision.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/selection/detail/choice_comparison.h"
#include "libhybrid/selection/detail/segment_transforms.h"

namespace hybrid {
namespace {

/// Updates within which another value of a choice must lower the objective.
constexpr int kDelayedSettle = 4;
/// Choices tried after one update, those of largest cost first.
constexpr std::size_t kTried = 4;
/// Cost below which no other value of a choice is tried.
constexpr double kEase = 1e-2;
constexpr int kFinalRounds = 5;
/// Largest number of joint values of a group.
constexpr std::size_t kJointValues = 1024;

/// The value that names an attempt to give a group its best joint value.
constexpr int kTakeBest = -1;

/// A table that allows one value.
Table only(DiscreteKey key, int value) {
  std::vector<double> costs(key.cardinality, std::numeric_limits<double>::infinity());
  costs[value] = 0.0;
  return {{key}, std::move(costs)};
}

bool is_step(const std::vector<Key>& keys) {
  return keys.size() == 2 && keys[0].letter() == keys[1].letter() &&
         keys[1].index() == keys[0].index() + 1;
}

bool is_closure(const ContinuousFactor& factor) {
  return factor.keys().size() == 2 && factor.types()[0] == Variable<SE2>::type() &&
         factor.types()[1] == Variable<SE2>::type() && !is_step(factor.keys());
}

}  // namespace

/// Runs change(report) and undoes all of it if it fails.
template <class Change>
UpdateReport DelayedDecisionSmoother::all_or_nothing(const Change& change) {
  const auto start = std::chrono::steady_clock::now();
  const auto save = [&] {
    return State{choices_.size(), open_, groups_, explained_, settled_, trials_};
  };
  const auto restore = [&](State&& before) {
    choices_.resize(before.choices);
    open_ = std::move(before.open);
    groups_ = std::move(before.groups);
    explained_ = before.explained;
    settled_ = before.settled;
    trials_ = before.trials;
    held_ = {};
  };
  auto report = attempts_.run<UpdateReport>(smoother_, save, restore, change);
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

UpdateReport DelayedDecisionSmoother::update(const Delta& delta) {
  return all_or_nothing([&](UpdateReport& report) { take_in(delta, report); });
}

void DelayedDecisionSmoother::take_in(Delta delta, UpdateReport& report) {
  const bool chained = is_chained(delta);
  const std::vector<ContinuousFactorPtr> kept =
      chained ? keep_back(delta) : std::vector<ContinuousFactorPtr>();
  if (!chained) let_all_in();
  report = taken(smoother_.update(delta));
  for (const auto& factor : delta.continuous) explained_ += 0.5 * factor->rows();
  for (const HybridFactorPtr& factor : delta.hybrid) {
    if (factor->discrete_keys().size() != 1) continue;
    if (motion_of(*factor, 0)) open_.push_back(choices_.size());
    choices_.push_back({factor->discrete_keys()[0], factor});
  }
  for (const ContinuousFactorPtr& closure : kept) {
    join(spanned(*closure)).closures.push_back(closure);
  }
  for (std::size_t g = groups_.size(); g-- > 0;) {
    if (groups_[g].compared) continue;
    compare(groups_[g]);
    take(groups_[g]);
    if (settled(groups_[g])) let_in(g);
  }
  const double cost = smoother_.objective() - smoother_.constant();
  if (cost - settled_ > options_.surprise + explained_) {
    while (resolve()) {
    }
  }
  settled_ = smoother_.objective() - smoother_.constant();
  explained_ = 0.0;
}

/// Whether every new pose has a factor with the one before it, and all other factors but closures
/// involve a new variable. If not, open choices may not be the only connection of the poses on both
/// sides.
bool DelayedDecisionSmoother::is_chained(const Delta& delta) const {
  const auto has_step = [&](Key pose) {
    const auto holds = [&](const auto& factor) {
      return is_step(factor->keys()) && factor->keys()[1] == pose;
    };
    return std::any_of(delta.continuous.begin(), delta.continuous.end(), holds) ||
           std::any_of(delta.hybrid.begin(), delta.hybrid.end(), holds);
  };
  for (Key key : delta.values.keys()) {
    if (delta.values.type(key) == Variable<SE2>::type() && !has_step(key)) return false;
  }
  const auto is_new = [&](Key key) { return delta.values.contains(key); };
  const auto harmless = [&](const auto& factor) {
    const std::vector<Key>& keys = factor->keys();
    return keys.size() < 2 || is_step(keys) || std::any_of(keys.begin(), keys.end(), is_new);
  };
  return std::all_of(delta.continuous.begin(), delta.continuous.end(),
                     [&](const auto& f) { return is_closure(*f) || harmless(f); }) &&
         std::all_of(delta.hybrid.begin(), delta.hybrid.end(), harmless);
}

/// Removes the closures that span open choices from a change, and returns them.
std::vector<ContinuousFactorPtr> DelayedDecisionSmoother::keep_back(Delta& delta) const {
  const auto known = [&](Key key) {
    const Values& values = delta.values.contains(key) ? delta.values : smoother_.values();
    return values.contains(key) && values.type(key) == Variable<SE2>::type();
  };
  const auto opens = [&](const ContinuousFactor& closure) {
    const auto [low, high] = std::minmax(closure.keys()[0], closure.keys()[1]);
    return std::any_of(delta.hybrid.begin(), delta.hybrid.end(),
                       [&, low = low, high = high](const HybridFactorPtr& choice) {
                         return motion_of(*choice, 0) && !(choice->keys()[0] < low) &&
                                !(high < choice->keys()[1]);
                       });
  };
  std::vector<ContinuousFactorPtr> kept, rest;
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    const bool keep = is_closure(*factor) && known(factor->keys()[0]) && known(factor->keys()[1]) &&
                      (opens(*factor) || !spanned(*factor).empty());
    (keep ? kept : rest).push_back(factor);
  }
  delta.continuous = std::move(rest);
  return kept;
}

/// The open choices between the poses of a closure.
std::vector<std::size_t> DelayedDecisionSmoother::spanned(const ContinuousFactor& closure) const {
  const auto [low, high] = std::minmax(closure.keys()[0], closure.keys()[1]);
  std::vector<std::size_t> choices;
  for (std::size_t c : open_) {
    const std::vector<Key>& keys = choices_[c].factor->keys();
    if (!(keys[0] < low) && !(high < keys[1])) choices.push_back(c);
  }
  return choices;
}

/// A group of the given choices, merged with all groups that share one of them.
DelayedDecisionSmoother::Group& DelayedDecisionSmoother::join(
    const std::vector<std::size_t>& choices) {
  Group joined;
  joined.values.emplace_back();
  std::vector<Group> others;
  for (Group& group : groups_) {
    const bool shares = std::any_of(choices.begin(), choices.end(), [&](std::size_t c) {
      return std::count(group.choices.begin(), group.choices.end(), c) != 0;
    });
    if (!shares) {
      others.push_back(std::move(group));
      continue;
    }
    std::vector<std::vector<int>> product;
    for (const std::vector<int>& a : joined.values) {
      for (const std::vector<int>& b : group.values) {
        if (product.size() == kJointValues) break;
        product.push_back(a);
        product.back().insert(product.back().end(), b.begin(), b.end());
      }
    }
    joined.values = std::move(product);
    joined.choices.insert(joined.choices.end(), group.choices.begin(), group.choices.end());
    joined.closures.insert(joined.closures.end(), group.closures.begin(), group.closures.end());
  }
  // The newest first: beyond the limit of joint values, the oldest keep their present values.
  for (auto c = choices.rbegin(); c != choices.rend(); ++c) {
    if (std::count(joined.choices.begin(), joined.choices.end(), *c) == 0) extend(joined, *c);
  }
  others.push_back(std::move(joined));
  groups_ = std::move(others);
  return groups_.back();
}

/// Adds a choice to a group, with all its values if the number of joint values allows it.
void DelayedDecisionSmoother::extend(Group& group, std::size_t choice) {
  const int now = value_of(choice), cardinality = choices_[choice].key.cardinality;
  const std::size_t count = group.values.size();
  group.choices.push_back(choice);
  for (std::size_t i = 0; i < count; ++i) group.values[i].push_back(now);
  if (count * cardinality > kJointValues) return;
  for (int value = 0; value < cardinality; ++value) {
    for (std::size_t i = 0; i < count && value != now; ++i) {
      group.values.push_back(group.values[i]);
      group.values.back().back() = value;
    }
  }
}

int DelayedDecisionSmoother::value_of(std::size_t choice) const {
  return smoother_.assignment().at(choices_[choice].key.key);
}

/// Drops the joint values of a group that its closures contradict, and sorts the others, the best
/// first.
void DelayedDecisionSmoother::compare(Group& group) {
  std::vector<std::size_t> order(group.choices.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return group.choices[a] < group.choices[b]; });
  std::vector<HybridFactorPtr> factors;
  for (std::size_t i : order) factors.push_back(choices_[group.choices[i]].factor);
  const ChoiceComparison comparison(smoother_, factors, group.closures);
  std::vector<std::pair<double, std::size_t>> costs;
  for (std::size_t v = 0; v < group.values.size(); ++v) {
    std::vector<int> values;
    for (std::size_t i : order) values.push_back(group.values[v][i]);
    costs.emplace_back(comparison.cost(values), v);
  }
  std::sort(costs.begin(), costs.end());
  std::vector<std::vector<int>> left;
  for (const auto& [cost, v] : costs) {
    if (cost <= costs[0].first + options_.margin) left.push_back(std::move(group.values[v]));
  }
  group.values = std::move(left);
  group.compared = true;
}

bool DelayedDecisionSmoother::settled(const Group& group) const {
  return group.values.size() == 1 || group.closures.size() >= options_.patience;
}

/// Adds the closures of a group to the smoother and ends the group.
void DelayedDecisionSmoother::let_in(std::size_t g) {
  const Group group = std::move(groups_[g]);
  groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(g));
  const auto decided = [&](std::size_t c) {
    return std::count(group.choices.begin(), group.choices.end(), c) != 0;
  };
  open_.erase(std::remove_if(open_.begin(), open_.end(), decided), open_.end());
  Delta delta;
  delta.continuous = group.closures;
  taken(smoother_.update(delta));
  for (const auto& factor : delta.continuous) explained_ += 0.5 * factor->rows();
}

void DelayedDecisionSmoother::let_all_in() {
  while (!groups_.empty()) let_in(groups_.size() - 1);
  open_.clear();
}

std::size_t DelayedDecisionSmoother::waiting() const {
  std::size_t count = 0;
  for (const Group& group : groups_) count += group.closures.size();
  return count;
}

/// Gives the choices of a group their best joint value, and moves the poses behind them
/// accordingly.
void DelayedDecisionSmoother::take(const Group& group) {
  std::vector<std::pair<std::size_t, int>> chosen;
  for (std::size_t i = 0; i < group.choices.size(); ++i) {
    const int value = group.values[0][i];
    if (value_of(group.choices[i]) != value) chosen.emplace_back(group.choices[i], value);
  }
  if (chosen.empty()) return;
  std::sort(chosen.begin(), chosen.end());
  SegmentTransforms motions;
  Delta holds;
  for (const auto& [choice, value] : chosen) {
    motions.add(*choices_[choice].factor, value, smoother_.values());
    holds.discrete.push_back(only(choices_[choice].key, value));
  }
  IncrementalSmoother::Snapshot estimate = smoother_.snapshot();
  double* x = estimate.numbers.data();
  for (Key key : estimate.keys) {
    const VariableType type = smoother_.values().type(key);
    if (type == Variable<SE2>::type()) motions(key, SE2::load(x)).store(x);
    x += type.size;
  }
  attempts_.attempt({chosen[0].first, kTakeBest}, [&] {
    Delta lifts;
    lifts.remove = taken(smoother_.update(holds)).handles.discrete;
    taken(smoother_.restore(estimate));
    taken(smoother_.update(lifts));
  });
}

UpdateReport DelayedDecisionSmoother::finish() {
  return all_or_nothing([&](UpdateReport& report) {
    let_all_in();
    report = taken(smoother_.converge());
    for (int round = 0; round < kFinalRounds && resolve(); ++round) {
      report.add(taken(smoother_.converge()));
    }
  });
}

/// The choices of largest cost.
std::vector<std::size_t> DelayedDecisionSmoother::strained() const {
  std::vector<std::pair<double, std::size_t>> list;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    const Component component = choices_[c].factor->given(smoother_.assignment());
    if (component.factor == nullptr) continue;
    const double cost = component.factor->cost(smoother_.values());
    if (cost > kEase) list.emplace_back(cost, c);
  }
  std::sort(list.rbegin(), list.rend());
  if (list.size() > kTried) list.resize(kTried);
  std::vector<std::size_t> choices;
  for (const auto& [cost, c] : list) choices.push_back(c);
  return choices;
}

/// Tries other values of the choices of largest cost; returns whether one was better.
bool DelayedDecisionSmoother::resolve() {
  for (std::size_t c : strained()) {
    const int now = value_of(c);
    for (int value = 0; value < choices_[c].key.cardinality; ++value) {
      if (value != now && try_value(c, value)) return true;
    }
  }
  return false;
}

/// Gives a choice another value if that lowers the objective and leaves no variable undetermined;
/// returns whether it did.
bool DelayedDecisionSmoother::try_value(std::size_t choice, int value) {
  ++trials_;
  bool better = false;
  attempts_.attempt({choice, value}, [&] { better = is_better(choices_[choice].key, value); });
  return better;
}

/// Fixes a choice to another value for some updates; restores the old one unless the objective
/// falls.
bool DelayedDecisionSmoother::is_better(DiscreteKey key, int value) {
  const double before = smoother_.objective();
  const IncrementalSmoother::Snapshot estimate = smoother_.snapshot();
  const int now = smoother_.assignment().at(key.key);
  hold(key, value);
  for (int i = 1; i < kDelayedSettle && !(smoother_.objective() < before); ++i)
    taken(smoother_.update({}));
  const bool better = smoother_.objective() < before;
  if (!better) {
    hold(key, now);
    taken(smoother_.restore(estimate));
  }
  lift();
  return better;
}

void DelayedDecisionSmoother::hold(DiscreteKey key, int value) {
  Delta delta;
  if (held_.valid()) delta.remove.push_back(held_);
  delta.discrete.push_back(only(key, value));
  held_ = taken(smoother_.update(delta)).handles.discrete[0];
}

void DelayedDecisionSmoother::lift() {
  Delta delta;
  delta.remove.push_back(held_);
  taken(smoother_.update(delta));
  held_ = {};
}

}  // namespace hybrid
