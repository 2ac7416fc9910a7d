// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Choices take other values: the best of a group, or where later measurements contradict them.
#include <algorithm>
#include <map>
#include <utility>

#include "libhybrid/choices/choices.h"
#include "libhybrid/choices/detail/segment_transforms.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// Choices tried after one update, those of largest cost first.
constexpr std::size_t kTried = 4;
/// Updates within which another value of a choice must lower the objective.
constexpr int kUpdatesToFall = 6;

/// A table that allows one value of a choice.
Table table_of(DiscreteKey key, int value) {
  std::vector<double> costs(key.cardinality, kInfinity);
  costs[value] = 0.0;
  return {{key}, std::move(costs)};
}

/// Fixes a choice to another value for some updates; returns whether the objective falls.
bool is_better(DiscreteKey key, int value, IncrementalSmoother& smoother) {
  const double before = smoother.objective();
  Delta hold, lift;
  hold.discrete.push_back(table_of(key, value));
  lift.remove = taken(smoother.update(hold)).handles.discrete;
  for (int i = 1; i < kUpdatesToFall && !(smoother.objective() < before); ++i) {
    taken(smoother.update({}));
  }
  if (!(smoother.objective() < before)) return false;
  taken(smoother.update(lift));
  return true;
}

}  // namespace

/// The choices of a group, in the order of their poses, that its best joint value changes.
std::vector<std::pair<std::size_t, int>> Choices::changed(
    const ChoiceGroup& group, const IncrementalSmoother& smoother) const {
  std::vector<std::pair<std::size_t, int>> chosen;
  for (std::size_t i = 0; i < group.choices.size(); ++i) {
    const int value = group.values[0][i];
    if (value_of(group.choices[i], smoother) != value) chosen.emplace_back(group.choices[i], value);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void Choices::take(const ChoiceGroup& group, IncrementalSmoother& smoother) const {
  const std::vector<std::pair<std::size_t, int>> chosen = changed(group, smoother);
  if (chosen.empty()) return;
  in_the_plane(group) ? take_as<SE2>(chosen, smoother) : take_as<SE3>(chosen, smoother);
}

template <class Pose>
void Choices::take_as(const std::vector<std::pair<std::size_t, int>>& chosen,
                      IncrementalSmoother& smoother) const {
  SegmentTransforms<Pose> motions;
  Delta holds;
  for (const auto& [choice, value] : chosen) {
    motions.add(*choices_[choice].factor, value, smoother.values());
    holds.discrete.push_back(table_of(choices_[choice].key, value));
  }
  IncrementalSmoother::Snapshot estimate = smoother.snapshot();
  double* x = estimate.numbers.data();
  for (Key key : estimate.keys) {
    const VariableType type = smoother.values().type(key);
    if (type == Variable<Pose>::type()) motions(key, Pose::load(x)).store(x);
    x += type.size;
  }
  attempt(smoother, [&] {
    Delta lifts;
    lifts.remove = taken(smoother.update(holds)).handles.discrete;
    taken(smoother.restore(estimate));
    taken(smoother.update(lifts));
    return true;
  });
}

std::vector<std::vector<std::size_t>> Choices::doubted(const JudgedClosures& closures) const {
  std::vector<std::size_t> steps;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    if (is_choice_of_step(*choices_[c].factor)) steps.push_back(c);
  }
  std::vector<std::pair<double, std::vector<std::size_t>>> found;
  const auto doubt = [&](const std::vector<std::size_t>& choices) {
    std::size_t in = 0, out = 0;
    for (std::size_t k = 0; k < closures.factors.size(); ++k) {
      if (spanned(*closures.factors[k], choices) == 1) ++(closures.accepted[k] ? in : out);
    }
    if (in < out) found.emplace_back(double(in) / double(in + out), choices);
  };
  for (std::size_t i = 0; i < steps.size(); ++i) {
    doubt({steps[i]});
    if (i > 0) doubt({steps[i - 1], steps[i]});
  }
  std::sort(found.begin(), found.end());
  std::vector<std::vector<std::size_t>> groups;
  for (auto& [share, choices] : found) groups.push_back(std::move(choices));
  return groups;
}

/// How many of these choices a closure spans.
int Choices::spanned(const ContinuousFactor& closure,
                     const std::vector<std::size_t>& choices) const {
  const std::vector<Key>& keys = closure.keys();
  if (keys.size() != 2) return 0;
  const auto [low, high] = std::minmax(keys[0], keys[1]);
  return static_cast<int>(
      std::count_if(choices.begin(), choices.end(), [&, low = low, high = high](std::size_t c) {
        const std::vector<Key>& step = choices_[c].factor->keys();
        return !(step[0] < low) && !(high < step[1]);
      }));
}

ChoiceGroup Choices::compare_again(const std::vector<std::size_t>& choices,
                                   const JudgedClosures& closures,
                                   const IncrementalSmoother& smoother) const {
  OpenChoices apart;
  ChoiceGroup& group = join(choices, smoother, apart);
  std::size_t left_in = options_.patience / 2, left_out = options_.patience - left_in;
  for (std::size_t k = closures.factors.size(); k-- > 0 && left_in + left_out > 0;) {
    const int count = spanned(*closures.factors[k], choices);
    const bool in = closures.accepted[k];
    std::size_t& left = in ? left_in : left_out;
    if (left == 0 || count == 0 || (!in && count != 1)) continue;
    group.closures.push_back({closures.factors[k], k});
    --left;
  }
  compare(group, smoother);
  return group;
}

Estimate Choices::with(const ChoiceGroup& group, const IncrementalSmoother& smoother) {
  ++trials_;
  Estimate estimate = smoother.estimate();
  std::map<std::size_t, int> values;
  for (std::size_t i = 0; i < group.choices.size(); ++i) {
    values[group.choices[i]] = group.values[0][i];
    estimate.assignment.set(choices_[group.choices[i]].key.key, group.values[0][i]);
  }
  const auto move = [&](auto pose) {
    using Pose = decltype(pose);
    SegmentTransforms<Pose> motions;
    for (const auto& [c, value] : values) {
      motions.add(*choices_[c].factor, value, smoother.values());
    }
    for (Key key : estimate.values.keys()) {
      if (estimate.values.type(key) != Variable<Pose>::type()) continue;
      estimate.values.update(key, motions(key, estimate.values.at<Pose>(key)));
    }
  };
  if (in_the_plane(group)) {
    move(SE2());
  } else {
    move(SE3());
  }
  return estimate;
}

void Choices::revise(IncrementalSmoother& smoother) {
  if (choices_.empty()) return;
  const double cost = smoother.objective() - smoother.constant();
  if (cost - settled_ > options_.decisive + explained_) {
    while (resolve(smoother)) {
    }
  }
  settled_ = smoother.objective() - smoother.constant();
  explained_ = 0.0;
}

/// The choices of largest cost.
std::vector<std::size_t> Choices::strained(const IncrementalSmoother& smoother) const {
  std::vector<std::pair<double, std::size_t>> list;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    const Component component = choices_[c].factor->given(smoother.assignment());
    if (component.factor == nullptr) continue;
    list.emplace_back(component.factor->cost(smoother.values()), c);
  }
  std::sort(list.rbegin(), list.rend());
  if (list.size() > kTried) list.resize(kTried);
  std::vector<std::size_t> choices;
  for (const auto& [cost, c] : list) choices.push_back(c);
  return choices;
}

bool Choices::resolve(IncrementalSmoother& smoother) {
  for (std::size_t c : strained(smoother)) {
    const int now = value_of(c, smoother);
    for (int value = 0; value < choices_[c].key.cardinality; ++value) {
      if (value != now && try_value(c, value, smoother)) return true;
    }
  }
  return false;
}

/// Gives a choice another value if that lowers the objective and leaves no variable undetermined;
/// returns whether it did.
bool Choices::try_value(std::size_t choice, int value, IncrementalSmoother& smoother) {
  ++trials_;
  return attempt(smoother, [&] { return is_better(choices_[choice].key, value, smoother); });
}

}  // namespace hybrid
