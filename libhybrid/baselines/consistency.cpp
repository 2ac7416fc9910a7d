// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/consistency.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "libhybrid/baselines/detail/clique.h"
#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/geometry/uncertain_motion.h"

namespace hybrid {
namespace {

template <class Group>
std::optional<Uncertain<Group>> motion_of(const ContinuousFactor& factor) {
  const auto motion = relative_pose<Group>(factor);
  if (!motion) return std::nullopt;
  return Uncertain<Group>{motion->measured, motion->information.inverse()};
}

/// A relative pose followed by another, with the sum of their uncertainties.
template <class Group>
Uncertain<Group> followed_by(const Uncertain<Group>& a, const Uncertain<Group>& b) {
  Uncertain<Group> both = a * b;
  both.motion.normalize();
  return both;
}

/// The inverse of a relative pose.
template <class Group>
Uncertain<Group> reversed(const Uncertain<Group>& a) {
  const typename Group::Jacobian adjoint = a.motion.adjoint();
  return {a.motion.inverse(), adjoint * a.covariance * adjoint.transpose()};
}

/// Odometry of one or several chains of poses.
template <class Group>
struct Odometry {
  struct Place {
    int chain = 0;
    int index = 0;
  };

  explicit Odometry(const std::vector<ContinuousFactorPtr>& trusted) {
    std::unordered_map<Key, Uncertain<Group>> next;
    std::vector<Key> starts;
    for (const ContinuousFactorPtr& factor : trusted) {
      if (factor->keys().size() != 2) continue;
      const Key from = factor->keys()[0], to = factor->keys()[1];
      if (from.letter() != to.letter() || to.index() != from.index() + 1) continue;
      if (const auto step = motion_of<Group>(*factor)) {
        if (next.emplace(from, *step).second) starts.push_back(from);
      }
    }
    for (Key start : starts) {
      const Key before(start.letter(), start.index() - 1);
      if (start.index() > 0 && next.count(before) != 0) continue;
      follow(start, next);
    }
  }

  std::unordered_map<Key, Place> places;
  std::vector<std::vector<Uncertain<Group>>> steps;  // by chain

 private:
  void follow(Key key, const std::unordered_map<Key, Uncertain<Group>>& next) {
    const int chain = static_cast<int>(steps.size());
    auto& own = steps.emplace_back();
    while (true) {
      places.emplace(key, Place{chain, static_cast<int>(own.size())});
      const auto step = next.find(key);
      if (step == next.end()) return;
      own.push_back(step->second);
      key = Key(key.letter(), key.index() + 1);
    }
  }
};

/// The motions between some stops on a chain of odometry. Their covariances are sums over the
/// steps, in the frame of the end of the motion, and no differences of large sums, however long the
/// chain.
template <class Group>
class Track {
 public:
  using Way = Uncertain<Group>;

  Track(const std::vector<Way>& steps, std::vector<int> indices) : stops_(std::move(indices)) {
    sort_unique(stops_);
    for (std::size_t s = 1; s < stops_.size(); ++s) {
      Way gap = steps[stops_[s - 1]];
      for (int i = stops_[s - 1] + 1; i < stops_[s]; ++i) gap = followed_by(gap, steps[i]);
      gaps_.push_back(gap);
    }
  }

  int stop(int index) const {
    return static_cast<int>(std::lower_bound(stops_.begin(), stops_.end(), index) - stops_.begin());
  }
  /// The motions from one stop to every other.
  std::vector<Way> from(int stop) const {
    std::vector<Way> ways(stops_.size(), none());
    for (std::size_t s = stop + 1; s < ways.size(); ++s) {
      ways[s] = followed_by(ways[s - 1], gaps_[s - 1]);
    }
    for (int s = stop; s-- > 0;) ways[s] = followed_by(ways[s + 1], reversed(gaps_[s]));
    return ways;
  }
  /// The motions from every stop to one.
  std::vector<Way> to(int stop) const {
    std::vector<Way> ways(stops_.size(), none());
    for (std::size_t s = stop + 1; s < ways.size(); ++s) {
      ways[s] = followed_by(reversed(gaps_[s - 1]), ways[s - 1]);
    }
    for (int s = stop; s-- > 0;) ways[s] = followed_by(gaps_[s], ways[s + 1]);
    return ways;
  }

 private:
  static Way none() { return {Group(), Group::Jacobian::Zero()}; }

  std::vector<int> stops_;  // indices on the chain, ascending
  std::vector<Way> gaps_;   // from each stop to the next
};

template <class Group>
struct Closure {
  int chain;
  int from, to;  // indices on the chain
  Uncertain<Group> relative;
  std::size_t index;  // among the closures of the problem
};

/// Squared whitened error of the loop a -> c -> d -> b -> a of closures x = (a, b), y = (c, d).
template <class Group>
double loop_error(const Uncertain<Group>& x, const Uncertain<Group>& y,
                  const Uncertain<Group>& a_to_c, const Uncertain<Group>& d_to_b) {
  using Matrix = typename Group::Jacobian;
  const Uncertain<Group> around = followed_by(followed_by(a_to_c, y), d_to_b);
  const auto error = x.motion.between(around.motion).log();
  const Eigen::LLT<Matrix> factor(Matrix(x.covariance + around.covariance));
  return factor.matrixL().solve(error).squaredNorm();
}

/// The closures with both ends on one chain of odometry.
template <class Group>
std::vector<Closure<Group>> closures_on(const Odometry<Group>& odometry,
                                        const RobustProblem& problem) {
  std::vector<Closure<Group>> closures;
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const ContinuousFactor& factor = *problem.closures[k];
    const auto relative = motion_of<Group>(factor);
    if (!relative) continue;
    const auto from = odometry.places.find(factor.keys()[0]);
    const auto to = odometry.places.find(factor.keys()[1]);
    if (from == odometry.places.end() || to == odometry.places.end()) continue;
    if (from->second.chain != to->second.chain) continue;
    closures.push_back({from->second.chain, from->second.index, to->second.index, *relative, k});
  }
  return closures;
}

template <class Group>
void compare_pairs(const RobustProblem& problem, const ConsistencyOptions& options,
                   Consistency& result) {
  const Odometry<Group> odometry(problem.trusted);
  const std::vector<Closure<Group>> closures = closures_on(odometry, problem);
  if (closures.size() > static_cast<std::size_t>(options.max_closures)) {
    throw Error("pairwise consistency of " + std::to_string(closures.size()) +
                " closures: the limit is " + std::to_string(options.max_closures));
  }
  std::vector<std::vector<int>> stops(odometry.steps.size());
  for (const Closure<Group>& c : closures) {
    stops[c.chain].insert(stops[c.chain].end(), {c.from, c.to});
  }
  std::vector<Track<Group>> tracks;
  for (std::size_t c = 0; c < stops.size(); ++c) tracks.emplace_back(odometry.steps[c], stops[c]);

  const double limit = chi_square_quantile(options.probability, Group::kDim);
  Adjacency agree(static_cast<int>(closures.size()));
  for (std::size_t i = 0; i < closures.size(); ++i) {
    const Closure<Group>& x = closures[i];
    const Track<Group>& track = tracks[x.chain];
    const auto from = track.from(track.stop(x.from));
    const auto to = track.to(track.stop(x.to));
    for (std::size_t j = 0; j < i; ++j) {
      const Closure<Group>& y = closures[j];
      if (y.chain == x.chain && !(loop_error(x.relative, y.relative, from[track.stop(y.from)],
                                             to[track.stop(y.to)]) <= limit)) {
        continue;
      }
      agree.join(static_cast<int>(i), static_cast<int>(j));
      ++result.pairs;
    }
  }
  const Clique clique = largest_clique(agree, options.max_nodes);
  for (const auto& closure : closures) result.kept[closure.index] = false;
  for (int v : clique.vertices) result.kept[closures[v].index] = true;
  result.compared += closures.size();
  result.exact = result.exact && clique.exact;
}

}  // namespace

Consistency pairwise_consistency(const RobustProblem& problem, const ConsistencyOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (!(options.probability > 0.0) || !(options.probability < 1.0)) {
    throw Error("the probability of pairwise consistency must be in (0, 1), got " +
                std::to_string(options.probability));
  }
  Consistency result;
  result.kept.assign(problem.closures.size(), true);
  compare_pairs<SE2>(problem, options, result);
  compare_pairs<SE3>(problem, options, result);
  result.seconds = seconds_since(start);
  return result;
}

RobustResult solve_consistent(const RobustProblem& problem, const ConsistencyOptions& options,
                              const MixtureOptions& mixture, const RobustSolver& solver) {
  const auto start = std::chrono::steady_clock::now();
  const Consistency consistency = pairwise_consistency(problem, options);
  RobustProblem kept{problem.trusted, {}, problem.initial};
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    if (consistency.kept[k]) kept.closures.push_back(problem.closures[k]);
  }
  RobustResult result = solver(kept);
  std::vector<bool> accepted(problem.closures.size(), false);
  for (std::size_t k = 0, compared = 0; k < accepted.size(); ++k) {
    if (consistency.kept[k]) accepted[k] = result.decisions[compared++].accepted();
  }
  const std::vector<ClosureDecision> by_solver = std::move(result.decisions);
  result.decisions = make_decisions(problem, result.values, accepted, mixture);
  for (std::size_t k = 0, compared = 0; k < accepted.size(); ++k) {
    if (consistency.kept[k]) result.decisions[k] = by_solver[compared++];
  }
  const JointObjective joint = joint_objective(problem, result.values, accepted, mixture);
  result.objective = joint.objective;
  result.cost = joint.cost;
  result.method += "+consistency";
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
