// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_map>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/robust/clique.h"
#include "libhybrid/robust/mixture_graph.h"

namespace hybrid {
namespace {

template <class Group>
struct RelativePose {
  Group measured;
  typename Group::Jacobian covariance;
};

template <class Group, class Factor>
RelativePose<Group> relative_pose_of(const Factor& factor) {
  const typename Group::Jacobian root = factor.sqrt_information().inverse();
  return {factor.measured(), root * root.transpose()};
}

template <class Group>
std::optional<RelativePose<Group>> relative_pose(const ContinuousFactor& factor) {
  if (const auto* between = dynamic_cast<const Between<Group>*>(&factor)) {
    return relative_pose_of<Group>(*between);
  }
  if constexpr (std::is_same_v<Group, SE2>) {
    if (const auto* between = dynamic_cast<const BetweenSE2*>(&factor)) {
      return relative_pose_of<SE2>(*between);
    }
  }
  return std::nullopt;
}

/// Odometry of one or several chains of poses, each seen from its own first pose.
template <class Group>
class Odometry {
 public:
  using Matrix = typename Group::Jacobian;
  struct Stop {
    int chain = 0;
    Group pose;           // T_first_stop
    Matrix adjoint_back;  // of its inverse
    Matrix uncertainty;   // of the way so far, in the frame of the first pose
  };

  explicit Odometry(const std::vector<ContinuousFactorPtr>& trusted) {
    std::unordered_map<Key, RelativePose<Group>> next;
    std::vector<Key> starts;
    for (const ContinuousFactorPtr& factor : trusted) {
      if (factor->keys().size() != 2) continue;
      const Key from = factor->keys()[0], to = factor->keys()[1];
      if (from.letter() != to.letter() || to.index() != from.index() + 1) continue;
      if (const auto step = relative_pose<Group>(*factor)) {
        if (next.emplace(from, *step).second) starts.push_back(from);
      }
    }
    int chains = 0;
    for (Key start : starts) {
      const Key before(start.letter(), start.index() - 1);
      if (start.index() > 0 && next.count(before) != 0) continue;
      follow(start, next, chains++);
    }
  }

  const Stop* find(Key key) const {
    const auto it = stops_.find(key);
    return it == stops_.end() ? nullptr : &it->second;
  }

 private:
  void follow(Key key, const std::unordered_map<Key, RelativePose<Group>>& next, int chain) {
    Stop stop{chain, Group(), Matrix::Identity(), Matrix::Zero()};
    while (true) {
      stops_.emplace(key, stop);
      const auto step = next.find(key);
      if (step == next.end()) return;
      stop.pose = stop.pose * step->second.measured;
      stop.pose.normalize();
      const Matrix adjoint = stop.pose.adjoint();
      stop.adjoint_back = stop.pose.inverse().adjoint();
      stop.uncertainty += adjoint * step->second.covariance * adjoint.transpose();
      key = Key(key.letter(), key.index() + 1);
    }
  }

  std::unordered_map<Key, Stop> stops_;
};

template <class Group>
struct Closure {
  using Stop = typename Odometry<Group>::Stop;
  const Stop* from;
  const Stop* to;
  RelativePose<Group> relative;
  std::size_t index;  // among the closures of the problem
};

/// Squared whitened error of the loop a -> c -> d -> b -> a of closures x = (a, b), y = (c, d).
template <class Group>
double loop_error(const Closure<Group>& x, const Closure<Group>& y) {
  using Matrix = typename Group::Jacobian;
  const auto way = [](const auto& from, const auto& to) {
    return Matrix(to.uncertainty - from.uncertainty);
  };
  const Group T_ac = x.from->pose.between(y.from->pose);
  const Group T_db = y.to->pose.between(x.to->pose);
  const Matrix back_db = T_db.inverse().adjoint();
  const Matrix back_cb = back_db * y.relative.measured.inverse().adjoint() * y.from->adjoint_back;
  // Ways are driven forwards or backwards: one of the differences of sums is the negative of it.
  const double sign_ac = way(*x.from, *y.from).trace() < 0.0 ? -1.0 : 1.0;
  const double sign_db = way(*y.to, *x.to).trace() < 0.0 ? -1.0 : 1.0;
  const Matrix covariance =
      x.relative.covariance + back_db * y.relative.covariance * back_db.transpose() +
      sign_ac * (back_cb * way(*x.from, *y.from) * back_cb.transpose()) +
      sign_db * (x.to->adjoint_back * way(*y.to, *x.to) * x.to->adjoint_back.transpose());
  const auto error = x.relative.measured.between(T_ac * y.relative.measured * T_db).log();
  const Eigen::LLT<Matrix> factor(covariance);
  if (factor.info() != Eigen::Success) return 0.0;  // so uncertain that nothing can be said
  return factor.matrixL().solve(error).squaredNorm();
}

template <class Group>
void judge_pairs(const RobustProblem& problem, const ConsistencyOptions& options,
                 Consistency& result) {
  const Odometry<Group> odometry(problem.trusted);
  std::vector<Closure<Group>> closures;
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const ContinuousFactor& factor = *problem.closures[k];
    const auto relative = relative_pose<Group>(factor);
    if (!relative) continue;
    const auto* from = odometry.find(factor.keys()[0]);
    const auto* to = odometry.find(factor.keys()[1]);
    if (from == nullptr || to == nullptr || from->chain != to->chain) continue;
    closures.push_back({from, to, *relative, k});
  }
  if (closures.size() > static_cast<std::size_t>(options.max_closures)) {
    throw Error("pairwise consistency of " + std::to_string(closures.size()) +
                " closures: the limit is " + std::to_string(options.max_closures));
  }
  const double limit = chi_square_quantile(options.probability, Group::kDim);
  Adjacency agree(static_cast<int>(closures.size()));
  for (std::size_t i = 0; i < closures.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool other_chain = closures[i].from->chain != closures[j].from->chain;
      if (!other_chain && !(loop_error(closures[i], closures[j]) <= limit)) continue;
      agree.join(static_cast<int>(i), static_cast<int>(j));
      ++result.pairs;
    }
  }
  const Clique clique = largest_clique(agree, options.max_nodes);
  for (const auto& closure : closures) result.kept[closure.index] = false;
  for (int v : clique.vertices) result.kept[closures[v].index] = true;
  result.judged += closures.size();
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
  judge_pairs<SE2>(problem, options, result);
  judge_pairs<SE3>(problem, options, result);
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
  for (std::size_t k = 0, judged = 0; k < accepted.size(); ++k) {
    if (consistency.kept[k]) accepted[k] = result.verdicts[judged++].accepted;
  }
  const std::vector<Verdict> by_solver = std::move(result.verdicts);
  result.verdicts = judge(problem, result.values, accepted, mixture);
  for (std::size_t k = 0, judged = 0; k < accepted.size(); ++k) {
    if (consistency.kept[k]) result.verdicts[k] = by_solver[judged++];
  }
  const JointObjective joint = joint_objective(problem, result.values, accepted, mixture);
  result.objective = joint.objective;
  result.cost = joint.cost;
  result.method += "+consistency";
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
