// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/hypothesis_judge.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/factors/between.h"

namespace hybrid {
namespace {

/// Updates that a choice has to bring the objective down.
constexpr int kSettle = 4;
/// Choices tried after one update, those under most strain first.
constexpr std::size_t kTried = 4;
/// Cost below which a choice is at ease.
constexpr double kEase = 1e-2;
constexpr int kFinalRounds = 5;
/// Joint values of open choices that are compared at most.
constexpr std::size_t kCombinations = 1024;

/// The motion that a value of a choice measures, if it is one from a pose to the next.
std::optional<SE2> motion_of(const HybridFactor& factor, int value) {
  if (factor.keys().size() != 2 || factor.keys()[1].index() != factor.keys()[0].index() + 1) {
    return std::nullopt;
  }
  Assignment assignment;
  assignment.set(factor.discrete_keys()[0].key, value);
  const ContinuousFactor* component = factor.given(assignment).factor;
  if (const auto* plain = dynamic_cast<const BetweenSE2*>(component)) return plain->measured();
  if (const auto* group = dynamic_cast<const Between<SE2>*>(component)) return group->measured();
  return std::nullopt;
}

/// A table that allows one value.
Table only(DiscreteKey key, int value) {
  std::vector<double> costs(key.cardinality, std::numeric_limits<double>::infinity());
  costs[value] = 0.0;
  return {{key}, std::move(costs)};
}

bool is_closure(const ContinuousFactor& factor) {
  return factor.keys().size() == 2 && factor.keys()[0].letter() == factor.keys()[1].letter() &&
         factor.keys()[1].index() != factor.keys()[0].index() + 1;
}

/// The rigid motion, in the map, of all poses from one on.
struct Swing {
  std::uint64_t from;
  SE2 motion;
};

SE2 swung(const std::vector<Swing>& swings, Key key, const SE2& pose) {
  SE2 result = pose;
  for (auto swing = swings.rbegin(); swing != swings.rend(); ++swing) {
    if (key.index() >= swing->from) return swing->motion * pose;
  }
  return result;
}

/// Adds the swing of a choice that takes a value, given the poses before and behind it; swings come
/// in the order of their poses, each with all those before it.
void add_swing(const HybridFactor& factor, int value, const SE2& before, const SE2& behind,
               std::vector<Swing>& swings) {
  const SE2 total = swings.empty() ? SE2() : swings.back().motion;
  const std::optional<SE2> motion = motion_of(factor, value);
  if (!motion) return;
  const SE2 moved = total * before * *motion;
  swings.push_back({factor.keys()[1].index(), moved * behind.inverse()});
}

}  // namespace

UpdateReport HypothesisJudge::update(const Delta& given) {
  const auto start = std::chrono::steady_clock::now();
  Delta delta = given;
  const std::size_t choices = choices_.size();
  for (const HybridFactorPtr& factor : delta.hybrid) {
    if (factor->discrete_keys().size() != 1) continue;
    if (motion_of(*factor, 0)) open_.push_back(choices_.size());
    choices_.push_back({factor->discrete_keys()[0], factor});
  }
  const auto take_back = [&] {
    choices_.resize(choices);
    while (!open_.empty() && open_.back() >= choices) open_.pop_back();
  };
  anticipate(delta);
  UpdateReport report;
  try {
    report = smoother_.update(delta);
  } catch (...) {
    take_back();
    throw;
  }
  if (report.status != UpdateReport::Status::kOk) {
    take_back();
    return report;
  }
  close(delta);
  // What the new factors add to the objective beyond their constants is cost.
  for (const auto& factor : delta.continuous) normalizer_ += factor->log_normalizer();
  for (const auto& factor : delta.hybrid) {
    const Component component = factor->given(smoother_.assignment());
    normalizer_ += component.constant;
    if (component.factor != nullptr) normalizer_ += component.factor->log_normalizer();
  }
  if (smoother_.objective() - normalizer_ > settled_ + options_.surprise) {
    while (resolve()) {
    }
  }
  settled_ = smoother_.objective() - normalizer_;
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

int HypothesisJudge::value_of(std::size_t choice, const Delta& delta) const {
  const Key key = choices_[choice].key.key;
  const int value = smoother_.assignment().find(key);
  if (value >= 0) return value;
  return std::max(0, delta.assignment.find(key));
}

/// Gives open choices the joint value that the closures of a change agree with best.
void HypothesisJudge::anticipate(Delta& delta) {
  std::vector<const ContinuousFactor*> closures;
  std::uint64_t oldest = ~std::uint64_t{0};
  const auto known = [&](Key key) {
    const Values& values = delta.values.contains(key) ? delta.values : smoother_.values();
    return values.contains(key) && values.type(key) == Variable<SE2>::type();
  };
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    if (!is_closure(*factor) || !known(factor->keys()[0]) || !known(factor->keys()[1])) continue;
    closures.push_back(factor.get());
    oldest = std::min({oldest, factor->keys()[0].index(), factor->keys()[1].index()});
  }
  std::vector<std::size_t> open;
  std::vector<int> now;
  std::size_t combinations = 1;
  for (std::size_t i = open_.size(); i-- > 0 && !closures.empty();) {
    const Choice& choice = choices_[open_[i]];
    if (choice.factor->keys()[0].index() < oldest) break;
    if (combinations * choice.key.cardinality > kCombinations) break;
    combinations *= choice.key.cardinality;
    open.insert(open.begin(), open_[i]);
    now.insert(now.begin(), value_of(open_[i], delta));
  }
  if (open.empty()) return;
  const auto pose = [&](Key key) {
    return (delta.values.contains(key) ? delta.values : smoother_.values()).at<SE2>(key);
  };
  double best = std::numeric_limits<double>::infinity();
  std::vector<int> best_values = now, values(open.size());
  for (std::size_t n = 0; n < combinations; ++n) {
    std::size_t rest = n;  // the first combination is that of today
    for (std::size_t c = 0; c < open.size(); ++c) {
      const int cardinality = choices_[open[c]].key.cardinality;
      values[c] = (now[c] + static_cast<int>(rest % cardinality)) % cardinality;
      rest /= cardinality;
    }
    std::vector<Swing> swings;
    for (std::size_t c = 0; c < open.size(); ++c) {
      const HybridFactor& factor = *choices_[open[c]].factor;
      add_swing(factor, values[c], pose(factor.keys()[0]), pose(factor.keys()[1]), swings);
    }
    double cost = 0.0;
    for (const ContinuousFactor* closure : closures) {
      double x[2][SE2::kSize];
      for (int end : {0, 1}) {
        const Key key = closure->keys()[end];
        swung(swings, key, pose(key)).store(x[end]);
      }
      const double* ends[] = {x[0], x[1]};
      cost += closure->cost(ends);
    }
    if (cost < best) {
      best = cost;
      best_values = values;
    }
  }
  if (best_values != now) take(open, best_values, delta);
}

/// Sets choices, and moves what hangs on them.
void HypothesisJudge::take(const std::vector<std::size_t>& open, const std::vector<int>& values,
                           Delta& delta) {
  std::vector<Swing> swings;
  const auto pose = [&](Key key) {
    return (delta.values.contains(key) ? delta.values : smoother_.values()).at<SE2>(key);
  };
  for (std::size_t c = 0; c < open.size(); ++c) {
    const HybridFactor& factor = *choices_[open[c]].factor;
    add_swing(factor, values[c], pose(factor.keys()[0]), pose(factor.keys()[1]), swings);
  }
  std::vector<double> estimate = smoother_.snapshot();
  double* x = estimate.data();
  for (Key key : smoother_.values().keys()) {
    const VariableType type = smoother_.values().type(key);
    if (type == Variable<SE2>::type()) swung(swings, key, SE2::load(x)).store(x);
    x += type.size;
  }
  Values fresh;
  for (Key key : delta.values.keys()) {
    const VariableType type = delta.values.type(key);
    fresh.insert(key, type, delta.values.data(key));
    if (type == Variable<SE2>::type()) fresh.update(key, swung(swings, key, pose(key)));
  }
  delta.values = std::move(fresh);
  Delta holds;
  for (std::size_t c = 0; c < open.size(); ++c) {
    const DiscreteKey key = choices_[open[c]].key;
    if (!smoother_.assignment().contains(key.key)) {
      delta.assignment.set(key.key, values[c]);
    } else if (smoother_.assignment().at(key.key) != values[c]) {
      holds.discrete.push_back(only(key, values[c]));
    }
  }
  if (holds.discrete.empty()) return;
  Delta lifts;
  lifts.remove = smoother_.update(holds).handles;
  smoother_.restore(estimate);
  smoother_.update(lifts);
}

/// Choices that the closures of a change span are open no more.
void HypothesisJudge::close(const Delta& delta) {
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    if (!is_closure(*factor)) continue;
    const auto [low, high] = std::minmax(factor->keys()[0].index(), factor->keys()[1].index());
    const auto spanned = [&, low = low, high = high](std::size_t c) {
      const std::vector<Key>& keys = choices_[c].factor->keys();
      return keys[0].index() >= low && keys[1].index() <= high;
    };
    open_.erase(std::remove_if(open_.begin(), open_.end(), spanned), open_.end());
  }
}

UpdateReport HypothesisJudge::finish() {
  const auto start = std::chrono::steady_clock::now();
  UpdateReport report = smoother_.converge();
  for (int round = 0; round < kFinalRounds && resolve(); ++round) {
    const UpdateReport again = smoother_.converge();
    report.rounds += again.rounds;
    report.flips += again.flips;
  }
  report.objective_after = smoother_.objective();
  report.seconds = seconds_since(start);
  return report;
}

/// The choices under most strain.
std::vector<HypothesisJudge::Strained> HypothesisJudge::strained() const {
  std::vector<Strained> list;
  for (std::size_t c = 0; c < choices_.size(); ++c) {
    const HybridFactor& factor = *choices_[c].factor;
    const Component component = factor.given(smoother_.assignment());
    if (component.factor == nullptr) continue;
    const double cost = component.factor->cost(smoother_.values());
    if (cost > kEase) list.push_back({cost, c});
  }
  std::sort(list.begin(), list.end(), [](const Strained& a, const Strained& b) {
    return a.cost != b.cost ? a.cost > b.cost : a.choice > b.choice;
  });
  if (list.size() > kTried) list.resize(kTried);
  return list;
}

/// Tries other values of strained choices; returns whether one was better.
bool HypothesisJudge::resolve() {
  for (const Strained& strained : strained()) {
    const Choice& choice = choices_[strained.choice];
    const int now = smoother_.assignment().at(choice.key.key);
    for (int value = 0; value < choice.key.cardinality; ++value) {
      if (value != now && try_value(choice, value)) return true;
    }
  }
  return false;
}

void HypothesisJudge::hold(DiscreteKey key, int value) {
  Delta delta;
  if (held_.valid()) delta.remove.push_back(held_);
  delta.discrete.push_back(only(key, value));
  held_ = smoother_.update(delta).handles[0];
}

void HypothesisJudge::lift() {
  Delta delta;
  delta.remove.push_back(held_);
  smoother_.update(delta);
  held_ = {};
}

bool HypothesisJudge::try_value(const Choice& choice, int value) {
  ++trials_;
  const double before = smoother_.objective();
  const std::vector<double> estimate = smoother_.snapshot();
  const Assignment assignment = smoother_.assignment();
  hold(choice.key, value);
  for (int i = 1; i < kSettle && !(smoother_.objective() < before); ++i) smoother_.update({});
  const bool better = smoother_.objective() < before;
  if (!better) {
    hold(choice.key, assignment.at(choice.key.key));
    smoother_.restore(estimate);
  }
  lift();
  return better;
}

}  // namespace hybrid
