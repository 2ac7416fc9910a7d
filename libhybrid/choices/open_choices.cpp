// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/choices/open_choices.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

namespace hybrid {
namespace {

/// Largest number of joint values of a group.
constexpr std::size_t kJointValues = 1024;

bool contains(const std::vector<std::size_t>& list, std::size_t x) {
  return std::find(list.begin(), list.end(), x) != list.end();
}

/// Puts the choices, closures and products of joint values of a group into another.
void merge(ChoiceGroup&& from, ChoiceGroup& into) {
  std::vector<std::vector<int>> product;
  for (const std::vector<int>& a : into.values) {
    for (const std::vector<int>& b : from.values) {
      if (product.size() == kJointValues) break;
      product.push_back(a);
      product.back().insert(product.back().end(), b.begin(), b.end());
    }
  }
  into.values = std::move(product);
  into.choices.insert(into.choices.end(), from.choices.begin(), from.choices.end());
  into.closures.insert(into.closures.end(), from.closures.begin(), from.closures.end());
}

/// Adds a choice to a group, with all its values if the number of joint values allows it.
void extend(std::size_t choice, int cardinality, int present, ChoiceGroup& group) {
  const std::size_t count = group.values.size();
  group.choices.push_back(choice);
  for (std::size_t i = 0; i < count; ++i) group.values[i].push_back(present);
  if (count * static_cast<std::size_t>(cardinality) > kJointValues) return;
  for (int value = 0; value < cardinality; ++value) {
    for (std::size_t i = 0; i < count && value != present; ++i) {
      group.values.push_back(group.values[i]);
      group.values.back().back() = value;
    }
  }
}

/// The remaining joint values of some choices of a group, the best first.
std::vector<std::vector<int>> values_of(const ChoiceGroup& group,
                                        const std::vector<std::size_t>& choices) {
  std::vector<std::vector<int>> values;
  std::set<std::vector<int>> known;
  for (const std::vector<int>& joint : group.values) {
    std::vector<int> of_these;
    for (std::size_t i = 0; i < group.choices.size(); ++i) {
      if (contains(choices, group.choices[i])) of_these.push_back(joint[i]);
    }
    if (known.insert(of_these).second) values.push_back(std::move(of_these));
  }
  return values;
}

}  // namespace

void OpenChoices::open(std::size_t number, const Choice& choice) {
  open_.push_back({number, choice.factor->keys()[0], choice.factor->keys()[1]});
}

std::vector<std::size_t> OpenChoices::between(Key a, Key b) const {
  const auto [low, high] = std::minmax(a, b);
  std::vector<std::size_t> choices;
  for (const Step& step : open_) {
    if (!(step.from < low) && !(high < step.to)) choices.push_back(step.number);
  }
  return choices;
}

ChoiceGroup& OpenChoices::join(const std::vector<std::size_t>& choices,
                               const std::vector<int>& cardinality,
                               const std::vector<int>& present) {
  ChoiceGroup joined;
  joined.values.emplace_back();
  std::vector<ChoiceGroup> others;
  for (ChoiceGroup& group : groups_) {
    const bool shares = std::any_of(choices.begin(), choices.end(),
                                    [&](std::size_t c) { return contains(group.choices, c); });
    if (shares) {
      merge(std::move(group), joined);
    } else {
      others.push_back(std::move(group));
    }
  }
  for (std::size_t i = choices.size(); i-- > 0;) {
    if (!contains(joined.choices, choices[i])) {
      extend(choices[i], cardinality[i], present[i], joined);
    }
  }
  others.push_back(std::move(joined));
  groups_ = std::move(others);
  return groups_.back();
}

std::vector<std::size_t> OpenChoices::spanned(const WaitingClosure& closure,
                                              const std::vector<std::size_t>& choices) const {
  std::vector<std::size_t> found;
  for (const std::size_t c : between(closure.factor->keys()[0], closure.factor->keys()[1])) {
    if (contains(choices, c)) found.push_back(c);
  }
  return found;
}

/// The choices of a group that closures tie together which are in, set by set.
std::vector<std::vector<std::size_t>> OpenChoices::tied(const ChoiceGroup& group) const {
  std::vector<std::vector<std::size_t>> sets;
  for (const WaitingClosure& closure : group.closures) {
    if (!closure.in) continue;
    std::vector<std::size_t> all = spanned(closure, group.choices);
    const auto joins = [&](std::vector<std::size_t>& set) {
      const bool shares =
          std::any_of(set.begin(), set.end(), [&](std::size_t c) { return contains(all, c); });
      if (!shares) return false;
      for (const std::size_t c : set) {
        if (!contains(all, c)) all.push_back(c);
      }
      return true;
    };
    // A set that was joined may let another be.
    for (std::size_t before = 0; before != all.size();) {
      before = all.size();
      sets.erase(std::remove_if(sets.begin(), sets.end(), joins), sets.end());
    }
    if (!all.empty()) sets.push_back(std::move(all));
  }
  return sets;
}

std::vector<WaitingClosure> OpenChoices::settle(std::size_t g, std::size_t patience) {
  ChoiceGroup group = std::move(groups_[g]);
  groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(g));
  std::vector<std::size_t> decided;
  for (const std::vector<std::size_t>& set : tied(group)) {
    const auto ties = [&](const WaitingClosure& closure) {
      return closure.in && contains(set, spanned(closure, group.choices).front());
    };
    const auto count = std::count_if(group.closures.begin(), group.closures.end(), ties);
    if (values_of(group, set).size() == 1 || static_cast<std::size_t>(count) >= patience) {
      decided.insert(decided.end(), set.begin(), set.end());
    }
  }
  ChoiceGroup rest;
  for (const std::size_t c : group.choices) {
    if (!contains(decided, c)) rest.choices.push_back(c);
  }
  rest.values = values_of(group, rest.choices);
  rest.compared = true;
  std::vector<WaitingClosure> left;
  const auto out = [](const WaitingClosure& closure) { return !closure.in; };
  for (WaitingClosure& closure : group.closures) {
    (spanned(closure, rest.choices).empty() ? left : rest.closures).push_back(std::move(closure));
  }
  const auto first_out = std::stable_partition(rest.closures.begin(), rest.closures.end(),
                                               [&](const auto& closure) { return !out(closure); });
  if (static_cast<std::size_t>(rest.closures.end() - first_out) >= patience) {
    std::move(first_out, rest.closures.end(), std::back_inserter(left));
    rest.closures.erase(first_out, rest.closures.end());
  }
  open_.erase(std::remove_if(open_.begin(), open_.end(),
                             [&](const Step& step) { return contains(decided, step.number); }),
              open_.end());
  if (!rest.closures.empty()) groups_.push_back(std::move(rest));
  return left;
}

std::vector<WaitingClosure> OpenChoices::close_all() {
  std::vector<WaitingClosure> left;
  for (ChoiceGroup& group : groups_) {
    std::move(group.closures.begin(), group.closures.end(), std::back_inserter(left));
  }
  open_.clear();
  groups_.clear();
  return left;
}

std::size_t OpenChoices::waiting() const {
  std::size_t count = 0;
  for (const ChoiceGroup& group : groups_) count += group.closures.size();
  return count;
}

}  // namespace hybrid
