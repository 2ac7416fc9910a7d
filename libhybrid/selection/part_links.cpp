// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/part_links.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "libhybrid/core/move_variable.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/selection/detail/division.h"
#include "libhybrid/selection/detail/map_links.h"
#include "libhybrid/selection/detail/motion.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

/// Budgets of time: pairs of closures that are compared, and closures at least that are compared
/// with all others between their parts.
constexpr std::size_t kMostPairs = 100000;
constexpr std::size_t kLeastSeeds = 8;

/// A map at its estimate, which tells how sure it is of motions.
class LinearMap {
 public:
  LinearMap(const RobustProblem& problem, const RobustResult& result,
            const ClosureSelectionOptions& options)
      : graph_(factors_in_force(problem, accepted_closures(result.decisions))),
        values_(result.values),
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
    model_.variance_factor = result.variance_factor;
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

/// Leaves out the closures that have become trusted.
void erase_taken(const std::vector<bool>& taken, JoinedParts& joined) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (taken[k]) continue;
    joined.problem.closures[kept] = joined.problem.closures[k];
    joined.closures[kept++] = joined.closures[k];
  }
  joined.problem.closures.resize(kept);
  joined.closures.resize(kept);
}

/// What tells where the parts lie that are not in the map, with closures numbered as in the
/// problem; `alone` and `result` are the parts alone and their maps.
std::vector<MapLinks> links_to_map(const RobustProblem& problem, const RobustProblem& alone,
                                   const RobustResult& result, Division& division,
                                   const ClosureSelectionOptions& options) {
  Parts& parts = division.parts;
  std::map<Key, RobustProblem> part;
  std::map<Key, std::vector<std::size_t>> numbers;
  const Key map = division.has_map ? parts.of(division.names.front()) : Key();
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const Key name = parts.of(problem.closures[k]->keys()[0]);
    if (!is_absolute(*problem.closures[k]) || (division.has_map && name == map)) continue;
    part[name].closures.push_back(problem.closures[k]);
    numbers[name].push_back(k);
  }
  if (part.empty()) return {};
  const auto add = [&](const ContinuousFactorPtr& factor) {
    const auto own = part.find(parts.of(factor->keys()[0]));
    if (own != part.end()) own->second.trusted.push_back(factor);
  };
  for (const ContinuousFactorPtr& factor : problem.trusted) add(factor);
  for (std::size_t k = 0; k < alone.closures.size(); ++k) {
    if (result.decisions[k].accepted()) add(alone.closures[k]);
  }
  for (const Key key : result.values.keys()) {
    const auto own = part.find(parts.of(key));
    if (own == part.end()) continue;
    own->second.initial.insert(key, result.values.type(key), result.values.data(key));
  }
  std::vector<MapLinks> found;
  for (const auto& [name, own] : part) {
    found.push_back(find_map_links(own, options));
    for (std::size_t& k : found.back().closures) k = numbers[name][k];
  }
  return found;
}

/// Takes links to the map, and makes them trusted; those that are decided, or all. Returns whether
/// there were any.
bool take(const std::vector<MapLinks>& found, bool all, JoinedParts& joined) {
  RobustProblem& problem = joined.problem;
  std::vector<bool> taken(problem.closures.size(), false);
  const std::size_t before = joined.links.size();
  for (const MapLinks& links : found) {
    if (!links.decided && !all) continue;
    for (const std::size_t k : links.closures) {
      taken[k] = true;
      problem.trusted.push_back(problem.closures[k]);
      joined.links.push_back(
          {joined.closures[k], links.closures.size() + links.agreeing, 1 + links.agreeing, true});
    }
    for (const Key key : links.values.keys()) {
      const VariableType type = links.values.type(key);
      std::copy_n(links.values.data(key), type.size,
                  problem.initial.data(problem.initial.slot(key)));
    }
  }
  erase_taken(taken, joined);
  return joined.links.size() > before;
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
  erase_taken(taken, joined);
  return decided;
}

/// Whether there are parts to join, or one that closures measure in the map and nothing holds.
bool is_open(const Division& division, const RobustProblem& problem) {
  return division.names.size() > 1 ||
         (!division.has_map &&
          std::any_of(problem.closures.begin(), problem.closures.end(),
                      [](const ContinuousFactorPtr& closure) { return is_absolute(*closure); }));
}

}  // namespace

JoinedParts join_parts(const RobustProblem& problem, const ClosureSelectionOptions& options) {
  JoinedParts joined;
  joined.problem = problem;
  for (std::size_t k = 0; k < problem.closures.size(); ++k) joined.closures.push_back(k);
  for (Division division(problem); is_open(division, joined.problem);
       division = Division(joined.problem)) {
    const RobustProblem alone = parts_alone(joined.problem, division);
    const RobustResult result = select_closures(alone, options);
    const std::vector<MapLinks> to_map =
        links_to_map(joined.problem, alone, result, division, options);
    std::vector<Bridge> bridges;
    if (division.names.size() > 1) {
      LinearMap maps(alone, result, options);
      bridges = find_bridges(joined.problem, division, maps, options);
    }
    if (joined.candidates == 0) {
      for (const Bridge& bridge : bridges) joined.candidates += bridge.candidates;
    }
    joined.problem.initial = result.values;
    if (take(to_map, false, joined)) continue;
    const bool decided = !bridges.empty() && bridges.front().decided;
    if (!decided && take(to_map, true, joined)) continue;
    if (bridges.empty() || !take(bridges, division, joined)) break;
  }
  return joined;
}

std::vector<ClosureDecision> judge_links(const JoinedParts& joined, const RobustResult& result,
                                         const ClosureSelectionOptions& options) {
  if (joined.links.empty()) return {};
  const RobustProblem& problem = joined.problem;
  const LinearMap map(problem, result, options);
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
