// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Choices that were decided, and that later measurements contradict.
#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "libhybrid/selection/detail/segment_transforms.h"
#include "libhybrid/selection/online_selection.h"

namespace hybrid {
namespace {

/// Choices tried after one update, those of largest cost first.
constexpr std::size_t kTried = 4;

/// Names attempts to give a choice the value v: kValue + v. Smaller numbers are those of others.
constexpr int kValue = 4;

}  // namespace

/// A table that allows one value of a choice.
Table OnlineSelection::table_of(DiscreteKey key, int value) {
  std::vector<double> costs(key.cardinality, std::numeric_limits<double>::infinity());
  costs[value] = 0.0;
  return {{key}, std::move(costs)};
}

/// Choices that more closures contradict than support. A wrong choice keeps closures out that span
/// it; two that come one after the other and whose errors nearly cancel, those that span one of the
/// two. Those first of which the smallest share is in.
std::vector<std::vector<std::size_t>> OnlineSelection::doubted() const {
  std::vector<std::size_t> steps;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    if (is_choice_of_step(*choices_[c].factor)) steps.push_back(c);
  }
  std::vector<std::pair<double, std::vector<std::size_t>>> found;
  const auto doubt = [&](const std::vector<std::size_t>& choices) {
    std::size_t in = 0, out = 0;
    for (std::size_t k = 0; k < closures_.size(); ++k) {
      if (spanned(k, choices) == 1) ++(accepted(k) ? in : out);
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
int OnlineSelection::spanned(std::size_t closure, const std::vector<std::size_t>& choices) const {
  const std::vector<Key>& keys = closures_[closure].factor->keys();
  if (keys.size() != 2) return 0;
  const auto [low, high] = std::minmax(keys[0], keys[1]);
  return static_cast<int>(
      std::count_if(choices.begin(), choices.end(), [&, low = low, high = high](std::size_t c) {
        const std::vector<Key>& step = choices_[c].factor->keys();
        return !(step[0] < low) && !(high < step[1]);
      }));
}

/// The joint values of choices, the best first, by the newest closures that they keep out and the
/// newest that are in.
ChoiceGroup OnlineSelection::compared_again(const std::vector<std::size_t>& choices) const {
  OpenChoices apart;
  std::vector<int> cardinality, present;
  for (const std::size_t c : choices) {
    cardinality.push_back(choices_[c].key.cardinality);
    present.push_back(value_of(c));
  }
  ChoiceGroup& group = apart.join(choices, cardinality, present);
  std::size_t left_in = options_.patience / 2, left_out = options_.patience - left_in;
  for (std::size_t k = closures_.size(); k-- > 0 && left_in + left_out > 0;) {
    const int count = spanned(k, choices);
    const bool in = accepted(k);
    std::size_t& left = in ? left_in : left_out;
    if (left == 0 || count == 0 || (!in && count != 1)) continue;
    group.closures.push_back({closures_[k].factor, k});
    --left;
  }
  compare(group);
  return group;
}

/// Gives doubted choices other values: all closures are evaluated again under these, and they are
/// kept if the joint objective falls. `present` is the last such evaluation.
void OnlineSelection::revise_by_closures(RobustResult& present, SelectionReport& report) {
  std::set<std::pair<std::vector<std::size_t>, std::vector<int>>> tried;
  for (bool again = true; again;) {
    again = false;
    for (const std::vector<std::size_t>& choices : doubted()) {
      const ChoiceGroup group = compared_again(choices);
      const bool differs = [&] {
        for (std::size_t i = 0; i < group.choices.size(); ++i) {
          if (group.values[0][i] != value_of(group.choices[i])) return true;
        }
        return false;
      }();
      if (!differs || !tried.emplace(group.choices, group.values[0]).second) continue;
      ++trials_;
      RobustResult result = select_closures(problem_with(group), options_.selection);
      if (!(result.objective < present.objective)) continue;
      take(group);
      adopt(result, report);
      present = std::move(result);
      tried.clear();  // what was refused may pass now
      again = true;
      break;
    }
  }
}

/// The robust problem of all factors if a group had its best joint value, with the poses behind
/// its choices moved.
RobustProblem OnlineSelection::problem_with(const ChoiceGroup& group) const {
  Assignment assignment = smoother_.assignment();
  std::map<std::size_t, int> values;
  for (std::size_t i = 0; i < group.choices.size(); ++i) {
    values[group.choices[i]] = group.values[0][i];
    assignment.set(choices_[group.choices[i]].key.key, group.values[0][i]);
  }
  RobustProblem problem = this->problem(assignment);
  const auto move = [&](auto pose) {
    using Pose = decltype(pose);
    SegmentTransforms<Pose> motions;
    for (const auto& [c, value] : values) {
      motions.add(*choices_[c].factor, value, smoother_.values());
    }
    for (Key key : problem.initial.keys()) {
      if (problem.initial.type(key) != Variable<Pose>::type()) continue;
      problem.initial.update(key, motions(key, problem.initial.at<Pose>(key)));
    }
  };
  if (in_the_plane(group)) {
    move(SE2());
  } else {
    move(SE3());
  }
  return problem;
}

/// Tries other values of choices where the cost has risen more than noise explains.
void OnlineSelection::revise_choices() {
  if (choices_.empty()) return;
  const double cost = smoother_.objective() - smoother_.constant();
  if (cost - settled_ > options_.decisive + explained_) {
    while (resolve()) {
    }
  }
  settled_ = smoother_.objective() - smoother_.constant();
  explained_ = 0.0;
}

/// The choices of largest cost.
std::vector<std::size_t> OnlineSelection::strained() const {
  std::vector<std::pair<double, std::size_t>> list;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    const Component component = choices_[c].factor->given(smoother_.assignment());
    if (component.factor == nullptr) continue;
    list.emplace_back(component.factor->cost(smoother_.values()), c);
  }
  std::sort(list.rbegin(), list.rend());
  if (list.size() > kTried) list.resize(kTried);
  std::vector<std::size_t> choices;
  for (const auto& [cost, c] : list) choices.push_back(c);
  return choices;
}

/// Tries other values of the choices of largest cost; returns whether one was better.
bool OnlineSelection::resolve() {
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
bool OnlineSelection::try_value(std::size_t choice, int value) {
  ++trials_;
  bool better = false;
  attempts_.attempt({choice, kValue + value},
                    [&] { better = is_better(choices_[choice].key, value); });
  return better;
}

/// Fixes a choice to another value for some updates; restores the old one unless the objective
/// falls.
bool OnlineSelection::is_better(DiscreteKey key, int value) {
  const double before = smoother_.objective();
  const IncrementalSmoother::Snapshot estimate = smoother_.snapshot();
  const int now = smoother_.assignment().at(key.key);
  hold(key, value);
  for (int i = 1; i < kSettle && !(smoother_.objective() < before); ++i)
    taken(smoother_.update({}));
  const bool better = smoother_.objective() < before;
  if (!better) {
    hold(key, now);
    taken(smoother_.restore(estimate));
  }
  lift();
  return better;
}

void OnlineSelection::hold(DiscreteKey key, int value) {
  Delta delta;
  if (held_.valid()) delta.remove.push_back(held_);
  delta.discrete.push_back(table_of(key, value));
  held_ = taken(smoother_.update(delta)).handles.discrete[0];
}

void OnlineSelection::lift() {
  Delta delta;
  delta.remove.push_back(held_);
  taken(smoother_.update(delta));
  held_ = {};
}

}  // namespace hybrid
