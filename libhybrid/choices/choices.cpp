// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/choices/choices.h"

#include <algorithm>
#include <utility>

#include "libhybrid/choices/detail/choice_comparison.h"
#include "libhybrid/choices/detail/segment_transforms.h"
#include "libhybrid/selection/evidence.h"

namespace hybrid {
namespace {

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

void Choices::restore(State&& before) {
  choices_.resize(before.count);
  open_ = std::move(before.open);
  explained_ = before.explained;
  settled_ = before.settled;
  trials_ = before.trials;
}

void Choices::expect(const std::vector<ContinuousFactorPtr>& entering) {
  for (const auto& factor : entering) explained_ += 0.5 * factor->rows();
}

void Choices::note(const Delta& applied) {
  expect(applied.continuous);
  for (const HybridFactorPtr& factor : applied.hybrid) {
    if (factor->discrete_keys().size() != 1) continue;
    choices_.push_back({factor->discrete_keys()[0], factor});
    if (is_choice_of_step(*factor)) open_.open(choices_.size() - 1, choices_.back());
  }
}

bool is_chained(const Delta& delta) {
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

std::vector<ContinuousFactorPtr> Choices::keep_back(Delta& delta, const Values& present) const {
  const auto known = [&](Key key) {
    const Values& values = delta.values.contains(key) ? delta.values : present;
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
                      (opens(*factor) || !open_.between(keys[0], keys[1]).empty());
    (keep ? kept : rest).push_back(factor);
  }
  delta.continuous = std::move(rest);
  return kept;
}

int Choices::value_of(std::size_t choice, const IncrementalSmoother& smoother) const {
  return smoother.assignment().at(choices_[choice].key.key);
}

/// The group `among` others that these choices are in, which is to be compared.
ChoiceGroup& Choices::join(const std::vector<std::size_t>& choices,
                           const IncrementalSmoother& smoother, OpenChoices& among) const {
  std::vector<int> cardinality, present;
  for (const std::size_t c : choices) {
    cardinality.push_back(choices_[c].key.cardinality);
    present.push_back(value_of(c, smoother));
  }
  ChoiceGroup& group = among.join(choices, cardinality, present);
  group.compared = false;
  return group;
}

bool Choices::keep(const WaitingClosure& closure, const IncrementalSmoother& smoother) {
  const std::vector<Key>& keys = closure.factor->keys();
  const std::vector<std::size_t> choices = open_.between(keys.front(), keys.back());
  if (closure.number && !is_explained(closure.factor, choices, smoother)) return false;
  join(choices, smoother, open_).closures.push_back(closure);
  return true;
}

bool Choices::in_the_plane(const ChoiceGroup& group) const {
  return choices_[group.choices[0]].factor->types()[0] == Variable<SE2>::type();
}

/// Whether some joint value of choices explains a closure that may be false.
bool Choices::is_explained(const ContinuousFactorPtr& closure,
                           const std::vector<std::size_t>& choices,
                           const IncrementalSmoother& smoother) const {
  if (!is_closure(*closure)) return false;
  OpenChoices apart;
  ChoiceGroup& group = join(choices, smoother, apart);
  group.closures.push_back({closure, std::nullopt});
  return in_the_plane(group) ? is_explained_by<SE2>(group, smoother)
                             : is_explained_by<SE3>(group, smoother);
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
bool Choices::is_explained_by(const ChoiceGroup& group, const IncrementalSmoother& smoother) const {
  const auto comparison = comparison_of<Pose>(group, choices_, smoother, options_.selection);
  const double limit = options_.selection.gate * gate_quantile(Pose::kDim);
  const std::vector<std::size_t> order = in_order(group);
  return std::any_of(group.values.begin(), group.values.end(), [&](const auto& values) {
    return 2.0 * comparison.fit(ordered(values, order)).cost < limit;
  });
}

void Choices::compare(ChoiceGroup& group, const IncrementalSmoother& smoother) const {
  in_the_plane(group) ? compare_as<SE2>(group, smoother) : compare_as<SE3>(group, smoother);
}

/// Drops the joint values of a group that its closures contradict, and sorts the others, the best
/// first. Notes which closures are in under one of these.
template <class Pose>
void Choices::compare_as(ChoiceGroup& group, const IncrementalSmoother& smoother) const {
  const auto comparison = comparison_of<Pose>(group, choices_, smoother, options_.selection);
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

std::optional<std::vector<WaitingClosure>> Choices::decide_next(IncrementalSmoother& smoother) {
  for (std::size_t g = open_.groups().size(); g-- > 0;) {
    ChoiceGroup& group = open_.groups()[g];
    if (group.compared) continue;
    compare(group, smoother);
    take(group, smoother);
    return open_.settle(g, options_.patience);
  }
  return std::nullopt;
}

}  // namespace hybrid
