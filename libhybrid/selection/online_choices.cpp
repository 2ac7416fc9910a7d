// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Decisions about choices by the online selection.
#include <algorithm>
#include <utility>

#include "libhybrid/selection/detail/choice_comparison.h"
#include "libhybrid/selection/detail/evidence.h"
#include "libhybrid/selection/detail/segment_transforms.h"
#include "libhybrid/selection/online_selection.h"

namespace hybrid {
namespace {

/// Names attempts to give a group its best joint value.
constexpr int kTakeBest = 3;

bool is_step(const std::vector<Key>& keys) {
  return keys.size() == 2 && keys[0].letter() == keys[1].letter() &&
         keys[1].index() == keys[0].index() + 1;
}

bool is_closure(const ContinuousFactor& factor) {
  return factor.keys().size() == 2 && is_pose(factor.types()[0]) && is_pose(factor.types()[1]) &&
         !is_step(factor.keys());
}

/// The choices of a group in the order of their poses: indices into its lists.
std::vector<std::size_t> in_order(const ChoiceGroup& group) {
  std::vector<std::size_t> order(group.choices.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return group.choices[a] < group.choices[b]; });
  return order;
}

std::vector<int> ordered(const std::vector<int>& values, const std::vector<std::size_t>& order) {
  std::vector<int> out;
  for (const std::size_t i : order) out.push_back(values[i]);
  return out;
}

}  // namespace

void OnlineSelection::note_choices(const Delta& trusted) {
  for (const auto& factor : trusted.continuous) explained_ += 0.5 * factor->rows();
  for (const HybridFactorPtr& factor : trusted.hybrid) {
    if (factor->discrete_keys().size() != 1) continue;
    choices_.push_back({factor->discrete_keys()[0], factor});
    if (is_choice_of_step(*factor)) open_choices_.open(choices_.size() - 1, choices_.back());
  }
}

/// Whether every new pose has a factor with the one before it, and all other factors but closures
/// involve a new variable. If not, open choices may not be the only connection of the poses on both
/// sides.
bool OnlineSelection::is_chained(const Delta& delta) const {
  const auto has_step = [&](Key pose) {
    const auto holds = [&](const auto& factor) {
      return is_step(factor->keys()) && factor->keys()[1] == pose;
    };
    return std::any_of(delta.continuous.begin(), delta.continuous.end(), holds) ||
           std::any_of(delta.hybrid.begin(), delta.hybrid.end(), holds);
  };
  for (Key key : delta.values.keys()) {
    if (is_pose(delta.values.type(key)) && !has_step(key)) return false;
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
std::vector<ContinuousFactorPtr> OnlineSelection::keep_back(Delta& delta) const {
  const auto known = [&](Key key) {
    const Values& values = delta.values.contains(key) ? delta.values : smoother_.values();
    return values.contains(key) && is_pose(values.type(key));
  };
  const auto opens = [&](const ContinuousFactor& closure) {
    const auto [low, high] = std::minmax(closure.keys()[0], closure.keys()[1]);
    return std::any_of(delta.hybrid.begin(), delta.hybrid.end(),
                       [&, low = low, high = high](const HybridFactorPtr& choice) {
                         return is_choice_of_step(*choice) && !(choice->keys()[0] < low) &&
                                !(high < choice->keys()[1]);
                       });
  };
  std::vector<ContinuousFactorPtr> kept, rest;
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    const std::vector<Key>& keys = factor->keys();
    const bool keep = is_closure(*factor) && known(keys[0]) && known(keys[1]) &&
                      (opens(*factor) || !open_choices_.between(keys[0], keys[1]).empty());
    (keep ? kept : rest).push_back(factor);
  }
  delta.continuous = std::move(rest);
  return kept;
}

/// The group of open choices that a closure joins.
ChoiceGroup& OnlineSelection::join(const std::vector<std::size_t>& choices) {
  std::vector<int> cardinality, present;
  for (const std::size_t c : choices) {
    cardinality.push_back(choices_[c].key.cardinality);
    present.push_back(value_of(c));
  }
  ChoiceGroup& group = open_choices_.join(choices, cardinality, present);
  group.compared = false;
  return group;
}

int OnlineSelection::value_of(std::size_t choice) const {
  return smoother_.assignment().at(choices_[choice].key.key);
}

bool OnlineSelection::in_the_plane(const ChoiceGroup& group) const {
  return choices_[group.choices[0]].factor->types()[0] == Variable<SE2>::type();
}

/// Whether some joint value of choices explains a closure that may be false.
bool OnlineSelection::is_explained(const ContinuousFactorPtr& closure,
                                   const std::vector<std::size_t>& choices) const {
  if (!is_closure(*closure)) return false;
  OpenChoices apart;
  std::vector<int> cardinality, present;
  for (const std::size_t c : choices) {
    cardinality.push_back(choices_[c].key.cardinality);
    present.push_back(value_of(c));
  }
  ChoiceGroup& group = apart.join(choices, cardinality, present);
  group.closures.push_back({closure, std::nullopt});
  return in_the_plane(group) ? is_explained_by<SE2>(group) : is_explained_by<SE3>(group);
}

/// A comparison of the joint values of a group.
template <class Pose>
ChoiceComparison<Pose> comparison_of(const ChoiceGroup& group, const std::vector<Choice>& choices,
                                     const IncrementalSmoother& smoother,
                                     const ClosureSelectionOptions& options) {
  std::vector<HybridFactorPtr> factors;
  for (const std::size_t i : in_order(group)) factors.push_back(choices[group.choices[i]].factor);
  std::vector<ContinuousFactorPtr> sure, uncertain;
  for (const WaitingClosure& closure : group.closures) {
    (closure.number ? uncertain : sure).push_back(closure.factor);
  }
  return {smoother, factors, sure, uncertain, options, map_radius(smoother.values())};
}

template <class Pose>
bool OnlineSelection::is_explained_by(const ChoiceGroup& group) const {
  const auto comparison = comparison_of<Pose>(group, choices_, smoother_, options_.selection);
  const double limit = options_.selection.gate * gate_quantile(Pose::kDim);
  const std::vector<std::size_t> order = in_order(group);
  return std::any_of(group.values.begin(), group.values.end(), [&](const auto& values) {
    return 2.0 * comparison.fit(ordered(values, order)).cost < limit;
  });
}

void OnlineSelection::compare(ChoiceGroup& group) const {
  in_the_plane(group) ? compare_as<SE2>(group) : compare_as<SE3>(group);
}

/// Drops the joint values of a group that its closures contradict, and sorts the others, the best
/// first. Notes which closures are in under one of these.
template <class Pose>
void OnlineSelection::compare_as(ChoiceGroup& group) const {
  const auto comparison = comparison_of<Pose>(group, choices_, smoother_, options_.selection);
  const std::vector<std::size_t> order = in_order(group);
  std::vector<typename ChoiceComparison<Pose>::Fit> fits;
  std::vector<std::pair<double, std::size_t>> costs;
  for (std::size_t v = 0; v < group.values.size(); ++v) {
    fits.push_back(comparison.fit(ordered(group.values[v], order)));
    costs.emplace_back(-fits.back().evidence, v);
  }
  std::sort(costs.begin(), costs.end());
  for (WaitingClosure& closure : group.closures) closure.in = !closure.number;
  std::vector<std::vector<int>> left;
  for (const auto& [cost, v] : costs) {
    if (cost > costs[0].first + options_.decisive) break;
    left.push_back(std::move(group.values[v]));
    std::size_t k = 0;
    for (WaitingClosure& closure : group.closures) {
      if (closure.number && fits[v].in[k++]) closure.in = true;
    }
  }
  group.values = std::move(left);
  group.compared = true;
}

/// Compares the groups that closures have joined, and lets in what is decided.
void OnlineSelection::decide_choices(SelectionReport& report) {
  for (std::size_t g = open_choices_.groups().size(); g-- > 0;) {
    if (open_choices_.groups()[g].compared) continue;
    compare(open_choices_.groups()[g]);
    take(open_choices_.groups()[g]);
    let_in(open_choices_.settle(g, options_.patience), report);
  }
}

/// Adds the true ones of closures that have waited to the smoother, and tests the others.
void OnlineSelection::let_in(const std::vector<WaitingClosure>& closures, SelectionReport& report) {
  Delta delta;
  for (const WaitingClosure& closure : closures) {
    if (!closure.number) delta.continuous.push_back(closure.factor);
  }
  for (const auto& factor : delta.continuous) explained_ += 0.5 * factor->rows();
  if (!delta.continuous.empty()) report.add(taken(smoother_.update(delta)));
  bool admitted = false;
  for (const WaitingClosure& closure : closures) {
    if (!closure.number) continue;
    admitted = consider(*closure.number, report) || admitted;
  }
  if (admitted) open_ = reconsider(report);
}

void OnlineSelection::let_all_in(SelectionReport& report) {
  let_in(open_choices_.close_all(), report);
}

void OnlineSelection::take(const ChoiceGroup& group) {
  in_the_plane(group) ? take_as<SE2>(group) : take_as<SE3>(group);
}

/// Gives the choices of a group their best joint value, and moves the poses behind them
/// accordingly.
template <class Pose>
void OnlineSelection::take_as(const ChoiceGroup& group) {
  std::vector<std::pair<std::size_t, int>> chosen;
  for (std::size_t i = 0; i < group.choices.size(); ++i) {
    const int value = group.values[0][i];
    if (value_of(group.choices[i]) != value) chosen.emplace_back(group.choices[i], value);
  }
  if (chosen.empty()) return;
  std::sort(chosen.begin(), chosen.end());
  SegmentTransforms<Pose> motions;
  Delta holds;
  for (const auto& [choice, value] : chosen) {
    motions.add(*choices_[choice].factor, value, smoother_.values());
    holds.discrete.push_back(table_of(choices_[choice].key, value));
  }
  IncrementalSmoother::Snapshot estimate = smoother_.snapshot();
  double* x = estimate.numbers.data();
  for (Key key : estimate.keys) {
    const VariableType type = smoother_.values().type(key);
    if (type == Variable<Pose>::type()) motions(key, Pose::load(x)).store(x);
    x += type.size;
  }
  attempts_.attempt({chosen[0].first, kTakeBest}, [&] {
    Delta lifts;
    lifts.remove = taken(smoother_.update(holds)).handles.discrete;
    taken(smoother_.restore(estimate));
    taken(smoother_.update(lifts));
  });
}

}  // namespace hybrid
