// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/part_links.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

#include "libhybrid/core/move_variable.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/selection/detail/innovation.h"
#include "libhybrid/selection/detail/motion.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

/// Budgets of time: pairs of closures that are compared, and closures at least that are compared
/// with all others between their parts.
constexpr std::size_t kMostPairs = 100000;
constexpr std::size_t kLeastSeeds = 8;
/// Of the priors that hold each part while it is mapped alone [m, rad].
constexpr double kAnchorSigma = 1e-3;

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
  std::vector<Key> names;  // of the parts, that of the map first
  bool has_map = false;

  explicit Division(const RobustProblem& problem) {
    HybridGraph graph;
    for (const ContinuousFactorPtr& factor : problem.trusted) {
      graph.add(factor);
      for (const Key key : factor->keys()) parts.join(factor->keys()[0], key);
    }
    find_names(problem);
    if (names.size() < 2) return;
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

 private:
  void find_names(const RobustProblem& problem) {
    names.clear();
    std::vector<Key> keys = problem.initial.keys();
    std::sort(keys.begin(), keys.end());
    for (const Key key : keys) {
      const Key name = parts.of(key);
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
};

/// Whether all variables of a factor are in one part.
bool is_within(const ContinuousFactor& factor, Parts& parts) {
  const Key first = parts.of(factor.keys().at(0));
  return std::all_of(factor.keys().begin(), factor.keys().end(),
                     [&](Key key) { return parts.of(key) == first; });
}

/// A prior on a pose where it is.
ContinuousFactorPtr anchor(Key key, const Values& values) {
  if (values.type(key) == Variable<SE2>::type()) {
    return std::make_shared<Prior<SE2>>(key, values.at<SE2>(key),
                                        Noise::isotropic(SE2::kDim, kAnchorSigma));
  }
  return std::make_shared<Prior<SE3>>(key, values.at<SE3>(key),
                                      Noise::isotropic(SE3::kDim, kAnchorSigma));
}

/// All parts but that of the map are held where they are, and what else is measured of them in the
/// frame of the map is left out.
RobustProblem parts_alone(const RobustProblem& problem, Division& division) {
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
  for (const auto& [part, key] : first) alone.trusted.push_back(anchor(key, problem.initial));
  for (const ContinuousFactorPtr& closure : problem.closures) {
    if (is_within(*closure, parts)) alone.closures.push_back(closure);
  }
  return alone;
}

/// A map at its estimate, which tells how sure it is of motions.
class LinearMap {
 public:
  LinearMap(HybridGraph graph, const Values& values, double variance_factor,
            const ClosureSelectionOptions& options)
      : graph_(std::move(graph)),
        values_(values),
        problem_(graph_, values_, {}, options.solver.threads, WeakComponents::kUncoupled,
                 Elimination::kPlain),
        state_(problem_.load(values_)) {
    problem_.linearize(state_);
    problem_.assemble();
    const Undamped undamped = factorize_undamped(problem_);
    if (!undamped.free.empty()) throw Error(under_constrained_message(undamped.free));
    if (!undamped.usable) throw Error("a map is conditioned too badly to be factorised");
    predictor_ = std::make_unique<InnovationPredictor>(problem_, state_);
    model_.degrees = options.degrees_of_freedom;
    model_.gate = options.gate;
    model_.variance_factor = variance_factor;
    model_.radius = map_radius(values_);
  }
  LinearMap(const LinearMap&) = delete;

  const Values& values() const { return values_; }
  const EvidenceModel& model() const { return model_; }

  template <class Pose>
  Motion<Pose> motion(Key from, Key to) {
    if (from == to) return {};
    const Pose mean = values_.at<Pose>(from).between(values_.at<Pose>(to));
    const Between<Pose> factor(from, to, mean, Noise::unit(Pose::kDim));
    return {mean, predictor_->predict(factor).APAt};
  }
  /// A factor of the map against all others.
  GivenOthers without(const ContinuousFactor& factor, const SelectedInverse& inverse) const {
    return given_others(predictor_->predict_joined(factor, inverse), true);
  }
  SelectedInverse inverse(int threads) const {
    WorkerPool pool(threads);
    return {problem_.system().cholesky(), pool};
  }

 private:
  HybridGraph graph_;
  Values values_;
  Problem problem_;
  Problem::State state_;
  std::unique_ptr<InnovationPredictor> predictor_;
  EvidenceModel model_;
};

/// Trusted factors and accepted closures.
HybridGraph graph_in_force(const RobustProblem& problem, const RobustResult& result) {
  HybridGraph graph;
  for (const ContinuousFactorPtr& factor : problem.trusted) graph.add(factor);
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    if (result.decisions[k].accepted()) graph.add(problem.closures[k]);
  }
  return graph;
}

/// A closure from one part to another.
struct Crossing {
  std::size_t closure = 0;
  Key from, to;
  bool forward = true;  // the factor has the poses in this order
};

/// What would join two parts best.
struct Bridge {
  Crossing by;
  std::size_t candidates = 0, agreeing = 1;
  double excess = 0.0;  // of the evidence by those that agree beyond what chance gives
  bool decided = false;

  /// Whether it is to be taken first.
  bool operator<(const Bridge& other) const {
    if (decided != other.decided) return decided;
    return excess != other.excess ? excess > other.excess : by.closure < other.by.closure;
  }
};

template <class Pose>
Motion<Pose> measured(const ContinuousFactor& factor, bool forward) {
  const std::optional<RelativePose<Pose>> motion = relative_pose<Pose>(factor);
  if (!motion) throw Error("a " + factor.name() + " factor measures no relative pose");
  const Motion<Pose> there{motion->measured, motion->information.inverse()};
  return forward ? there : there.inverse();
}

/// The closure between two parts with which most others agree.
template <class Pose>
Bridge best_bridge(const std::vector<Crossing>& crossings, std::size_t seeds, LinearMap& maps,
                   const std::vector<ContinuousFactorPtr>& closures,
                   const ClosureSelectionOptions& options) {
  Bridge best;
  best.by = crossings.front();
  best.candidates = crossings.size();
  const double chance = std::log1p(static_cast<double>(crossings.size()));
  seeds = std::clamp(seeds, std::min(kLeastSeeds, crossings.size()), crossings.size());
  for (std::size_t s = 0; s < seeds; ++s) {
    Bridge bridge;
    bridge.by = crossings[s * crossings.size() / seeds];
    const Motion<Pose> across = measured<Pose>(*closures[bridge.by.closure], bridge.by.forward);
    for (const Crossing& other : crossings) {
      if (other.closure == bridge.by.closure) continue;
      const Motion<Pose> around = maps.motion<Pose>(other.from, bridge.by.from) * across *
                                  maps.motion<Pose>(bridge.by.to, other.to);
      const double evidence = evidence_for(*closures[other.closure],
                                           other.forward ? around : around.inverse(), maps.model());
      if (evidence <= chance) continue;
      bridge.excess += evidence - chance;
      ++bridge.agreeing;
    }
    if (!(bridge.excess > best.excess)) continue;
    bridge.candidates = best.candidates;
    best = bridge;
  }
  best.decided = best.excess > evidence_needed(best.candidates, options);
  return best;
}

/// The bridges between all parts that closures connect, those to be taken first in front; `count`
/// receives the number of closures between parts.
std::vector<Bridge> find_bridges(const RobustProblem& problem, Division& division, LinearMap& maps,
                                 const ClosureSelectionOptions& options) {
  std::map<std::pair<Key, Key>, std::vector<Crossing>> between;
  std::size_t count = 0;
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const std::vector<Key>& keys = problem.closures[k]->keys();
    if (keys.size() != 2 || is_within(*problem.closures[k], division.parts)) continue;
    const Key a = division.parts.of(keys[0]), b = division.parts.of(keys[1]);
    const bool forward = a < b;
    between[std::minmax(a, b)].push_back(
        {k, keys[forward ? 0 : 1], keys[forward ? 1 : 0], forward});
    ++count;
  }
  std::vector<Bridge> bridges;
  for (const auto& [parts, crossings] : between) {
    const bool planar = problem.closures[crossings[0].closure]->relative_pose_2d().has_value();
    const std::size_t seeds = kMostPairs / count;
    bridges.push_back(planar ? best_bridge<SE2>(crossings, seeds, maps, problem.closures, options)
                             : best_bridge<SE3>(crossings, seeds, maps, problem.closures, options));
  }
  std::sort(bridges.begin(), bridges.end());
  return bridges;
}

/// Moves the part of one end of a bridge to where the bridge has it. The part of the map stays, or
/// the first one.
template <class Pose>
void place(const Bridge& bridge, const ContinuousFactor& closure, Division& division,
           Values& values) {
  Key fixed = bridge.by.from, moved = bridge.by.to;
  Pose across = measured<Pose>(closure, bridge.by.forward).mean;
  Parts& parts = division.parts;
  if (parts.of(moved) == parts.of(division.names.front())) {
    std::swap(fixed, moved);
    across = across.inverse();
  }
  const Pose motion = values.at<Pose>(fixed) * across * values.at<Pose>(moved).inverse();
  for (const Key key : values.keys()) {
    if (parts.of(key) == parts.of(moved)) move_variable(motion, key, values);
  }
  parts.join(fixed, moved);
}

/// Takes bridges, and makes them trusted; those that are decided or, if there are none, all.
/// Returns whether they were decided.
bool take(const std::vector<Bridge>& bridges, Division& division, JoinedParts& joined) {
  const bool decided = bridges.front().decided;
  RobustProblem& problem = joined.problem;
  std::vector<bool> taken(problem.closures.size(), false);
  for (const Bridge& bridge : bridges) {
    if (bridge.decided != decided) break;
    if (division.parts.of(bridge.by.from) == division.parts.of(bridge.by.to)) continue;
    const std::size_t k = bridge.by.closure;
    if (problem.closures[k]->relative_pose_2d()) {
      place<SE2>(bridge, *problem.closures[k], division, problem.initial);
    } else {
      place<SE3>(bridge, *problem.closures[k], division, problem.initial);
    }
    taken[k] = true;
    problem.trusted.push_back(problem.closures[k]);
    joined.links.push_back({joined.closures[k], bridge.candidates, bridge.agreeing});
  }
  std::size_t kept = 0;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (taken[k]) continue;
    problem.closures[kept] = problem.closures[k];
    joined.closures[kept++] = joined.closures[k];
  }
  problem.closures.resize(kept);
  joined.closures.resize(kept);
  return decided;
}

}  // namespace

JoinedParts join_parts(const RobustProblem& problem, const ClosureSelectionOptions& options) {
  JoinedParts joined;
  joined.problem = problem;
  for (std::size_t k = 0; k < problem.closures.size(); ++k) joined.closures.push_back(k);
  for (Division division(problem); division.names.size() > 1; division = Division(joined.problem)) {
    const RobustProblem alone = parts_alone(joined.problem, division);
    const RobustResult result = select_closures(alone, options);
    LinearMap maps(graph_in_force(alone, result), result.values, result.variance_factor, options);
    const std::vector<Bridge> bridges = find_bridges(joined.problem, division, maps, options);
    if (bridges.empty()) break;
    if (joined.links.empty()) {
      for (const Bridge& bridge : bridges) joined.candidates += bridge.candidates;
    }
    joined.problem.initial = result.values;
    if (!take(bridges, division, joined)) break;
  }
  return joined;
}

std::vector<ClosureDecision> judge_links(const JoinedParts& joined, const RobustResult& result,
                                         const ClosureSelectionOptions& options) {
  if (joined.links.empty()) return {};
  const RobustProblem& problem = joined.problem;
  const LinearMap map(graph_in_force(problem, result), result.values, result.variance_factor,
                      options);
  const SelectedInverse inverse = map.inverse(options.solver.threads);
  std::vector<double> evidence, redundancy;
  for (const ClosureDecision& decision : result.decisions) {
    evidence.push_back(decision.evidence);
    redundancy.push_back(decision.redundancy);
  }
  std::vector<ClosureDecision> decisions = result.decisions;
  const std::size_t first = problem.trusted.size() - joined.links.size();
  for (std::size_t f = first; f < problem.trusted.size(); ++f) {
    const ContinuousFactor& link = *problem.trusted[f];
    const GivenOthers alone = map.without(link, inverse);
    evidence.push_back(map.model().log_ratio(alone.b, alone.S, link));
    redundancy.push_back(alone.redundancy);
    decisions.emplace_back();
    decisions.back().accept(true);
    decisions.back().chi_square = 2.0 * link.cost(result.values);
  }
  write_evidence(evidence, redundancy, {}, options, decisions);
  decisions.erase(decisions.begin(), decisions.end() - std::ptrdiff_t(joined.links.size()));
  for (ClosureDecision& decision : decisions) {
    if (!decision.checkable || !(decision.margin > 0.0)) decision.status = ClosureStatus::kTrusted;
  }
  return decisions;
}

}  // namespace hybrid
