// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {

/// Variables that trusted factors connect (union-find). A part is known by one of its variables.
class Parts {
 public:
  Key of(Key key) {
    Key at = key;
    while (parent_.emplace(at, at).first->second != at) at = parent_[at];
    parent_[key] = at;
    return at;
  }
  /// Connects two variables; the part of the first one gives its name to both.
  void join(Key a, Key b) { parent_[of(b)] = of(a); }

 private:
  std::unordered_map<Key, Key> parent_;
};

/// The parts of a problem. Those in the frame of the map are one part, if there are any.
struct Division {
  Parts parts;
  std::vector<Key> names;  ///< of the parts, that of the map first
  bool has_map = false;

  explicit Division(const RobustProblem& problem);

 private:
  void find_names(const RobustProblem& problem);
};

/// Whether a factor measures something in the frame of the map.
inline bool is_absolute(const ContinuousFactor& factor) {
  return factor.keys().size() == 1;
}

inline Division::Division(const RobustProblem& problem) {
  const HybridGraph graph(problem.trusted);
  for (const ContinuousFactorPtr& factor : problem.trusted) {
    for (const Key key : factor->keys()) parts.join(factor->keys()[0], key);
  }
  find_names(problem);
  const bool is_measured =
      std::any_of(problem.closures.begin(), problem.closures.end(),
                  [](const ContinuousFactorPtr& closure) { return is_absolute(*closure); });
  if (names.size() < 2 && !is_measured) return;
  std::map<Key, bool> is_held;  // by part; one without factors is not
  for (const ContinuousFactorPtr& factor : problem.trusted) {
    is_held[parts.of(factor->keys()[0])] = true;
  }
  for (const FreeVariable& variable : free_variables(graph, {problem.initial, {}})) {
    is_held[parts.of(variable.key)] = false;
  }
  std::optional<Key> map;
  for (const Key name : names) {
    if (!is_held[name]) continue;
    if (map) parts.join(*map, name);
    map = map.value_or(name);
  }
  has_map = map.has_value();
  find_names(problem);
  if (has_map) std::swap(*std::find(names.begin(), names.end(), *map), names.front());
}

inline void Division::find_names(const RobustProblem& problem) {
  names.clear();
  std::vector<Key> keys = problem.initial.keys();
  std::sort(keys.begin(), keys.end());
  for (const Key key : keys) {
    const Key name = parts.of(key);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
}

/// Whether all variables of a factor are in one part.
inline bool is_within(const ContinuousFactor& factor, Parts& parts) {
  const Key first = parts.of(factor.keys().at(0));
  return std::all_of(factor.keys().begin(), factor.keys().end(),
                     [&](Key key) { return parts.of(key) == first; });
}

/// Of the priors that hold each part while it is mapped alone [m, rad].
inline constexpr double kPartAnchorSigma = 1e-3;

/// A prior on a pose where it is.
inline ContinuousFactorPtr pose_anchor(Key key, const Values& values) {
  if (values.type(key) == Variable<SE2>::type()) {
    return std::make_shared<Prior<SE2>>(key, values.at<SE2>(key),
                                        Noise::isotropic(SE2::kDim, kPartAnchorSigma));
  }
  return std::make_shared<Prior<SE3>>(key, values.at<SE3>(key),
                                      Noise::isotropic(SE3::kDim, kPartAnchorSigma));
}

/// All parts but that of the map are held where they are, and what else is measured of them in the
/// frame of the map is left out.
inline RobustProblem parts_alone(const RobustProblem& problem, Division& division) {
  RobustProblem alone;
  alone.initial = problem.initial;
  Parts& parts = division.parts;
  const Key map = division.has_map ? parts.of(division.names.front()) : Key();
  for (const ContinuousFactorPtr& factor : problem.trusted) {
    if (factor->keys().size() > 1 || parts.of(factor->keys()[0]) == map) {
      alone.trusted.push_back(factor);
    }
  }
  std::map<Key, Key> first;  // pose by part
  for (const Key key : problem.initial.keys()) {
    if (!is_pose(problem.initial.type(key)) || parts.of(key) == map) continue;
    const auto [place, is_new] = first.emplace(parts.of(key), key);
    if (!is_new) place->second = std::min(place->second, key);
  }
  for (const auto& [part, key] : first) alone.trusted.push_back(pose_anchor(key, problem.initial));
  for (const ContinuousFactorPtr& closure : problem.closures) {
    const bool of_map = division.has_map && parts.of(closure->keys()[0]) == map;
    if (is_absolute(*closure) ? of_map : is_within(*closure, parts)) {
      alone.closures.push_back(closure);
    }
  }
  return alone;
}

}  // namespace hybrid
