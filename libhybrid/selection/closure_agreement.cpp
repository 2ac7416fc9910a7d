// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_agreement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/selection/innovation.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {
namespace {

/// Poses of a stretch: what a robot passes at once. Passages that differ by less at both ends are
/// one.
constexpr std::size_t kStretch = 20;
constexpr std::size_t kMostPassages = 200, kMostStretches = 32;  // budgets
constexpr double kGate = 0.999;
constexpr double kChance = 1e-3;  // of rivals that agree by chance anywhere
/// So many passages confirm what is trusted; it refutes what is off by more than so many times the
/// chi-square of the worst of them: twice its sigmas.
constexpr std::size_t kConfirming = 2;
constexpr double kFar = 4;

/// One passage, by the closure in its middle.
struct Passage {
  std::size_t closure = 0;
  std::size_t from = 0, to = 0;  // ranks of its poses along the path
};

bool are_near(std::size_t a, std::size_t b) {
  return std::max(a, b) - std::min(a, b) < 2 * kStretch;
}

/// Whether two passages may be one, in either direction.
bool are_near(const Passage& a, const Passage& b) {
  return (are_near(a.from, b.from) && are_near(a.to, b.to)) ||
         (are_near(a.from, b.to) && are_near(a.to, b.from));
}

/// What is trusted alone, such as the odometry, as a witness of closures.
class TrustedPath {
 public:
  TrustedPath(const RobustProblem& problem, const Values& values) {
    for (const ContinuousFactorPtr& factor : problem.trusted) graph_.add(factor);
    problem_.emplace(graph_, values, Assignment{});
    state_ = problem_->load(values);
    levenberg_marquardt(*problem_, state_);
    problem_->linearize(state_);
    problem_->assemble();
    if (problem_->factorize(0.0) < 0) predictor_.emplace(*problem_, state_);
  }

  /// Whether it has all poses in one part.
  bool tells() const { return predictor_.has_value(); }

  /// The chi-square by which a closure is off from it.
  double chi_square(const ContinuousFactor& closure) {
    const GivenOthers others = given_others(predictor_->predict(closure), false);
    return others.b.dot(others.S.ldlt().solve(others.b));
  }

 private:
  HybridGraph graph_;
  std::optional<Problem> problem_;
  Problem::State state_;
  std::optional<InnovationPredictor> predictor_;
};

template <class Pose>
class ClosureJudge {
 public:
  ClosureJudge(const RobustProblem& problem, const Values& values,
               const std::vector<bool>& accepted, double scale)
      : problem_(problem),
        values_(values),
        closures_(problem.closures),
        accepted_(accepted),
        marginals_(HybridGraph(factors_in_force(problem, accepted)), Estimate{values, {}}),
        gate_(scale * scale * chi_square_quantile(kGate, Pose::kDim)) {
    for (const Key key : values.keys()) {
      if (values.type(key) == Variable<Pose>::type()) path_.push_back(key);
    }
    std::sort(path_.begin(), path_.end());
    extent_ = longest_side();
  }

  ClosureAgreement judge() {
    std::vector<Passage> agreeing, contradicted;
    for (const Passage& passage : passages()) {
      const std::optional<bool> agrees = agrees_with_map(passage);
      if (agrees) (*agrees ? agreeing : contradicted).push_back(passage);
    }
    ClosureAgreement out;
    const std::vector<Passage> rivals = not_refuted(rivals_among(contradicted), agreeing);
    out.agreeing = agreeing.size();
    out.rivals = rivals.size();
    out.alone = contradicted.size() - rivals.size();
    out.ratio = ratio(out.agreeing, out.rivals);
    out.stretches = stretches(agreeing, rivals);
    for (const Passage& rival : rivals) out.rival_closures.push_back(rival.closure);
    return out;
  }

 private:
  using Jacobian = typename Pose::Jacobian;

  static double ratio(std::size_t agreeing, std::size_t rivals) {
    const std::size_t all = agreeing + rivals;
    return all > 0 ? double(agreeing) / double(all) : std::numeric_limits<double>::quiet_NaN();
  }

  std::size_t rank(Key key) const {
    return static_cast<std::size_t>(std::lower_bound(path_.begin(), path_.end(), key) -
                                    path_.begin());
  }

  std::vector<Passage> passages() const {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<Passage>> cells;
    for (std::size_t k = 0; k < closures_.size(); ++k) {
      const ContinuousFactor& factor = *closures_[k];
      if (!relative_pose<Pose>(factor)) continue;
      const std::size_t from = rank(factor.keys()[0]), to = rank(factor.keys()[1]);
      cells[std::minmax(from / kStretch, to / kStretch)].push_back({k, from, to});
    }
    std::vector<Passage> all;
    for (const auto& [cell, inside] : cells) all.push_back(inside[inside.size() / 2]);
    return evenly_chosen(all, kMostPassages);
  }

  /// Whether the rest of the map predicts a closure; nothing where the rest does not tell. A map
  /// that is too unsure to confirm one may still contradict it.
  std::optional<bool> agrees_with_map(const Passage& passage) const {
    const ContinuousFactorPtr& factor = closures_[passage.closure];
    const bool in_force = accepted_[passage.closure];
    Eigen::VectorXd b(factor->rows());
    Eigen::MatrixXd J(factor->rows(), factor->cols());
    const auto x = gather(factor->keys(), factor->types(), values_);
    factor->linearize(x.data(), b.data(), J.data());
    try {
      const Eigen::MatrixXd P = marginals_.joint_covariance(factor->keys());
      const GivenOthers held_out = given_others({b, J * P * J.transpose()}, in_force);
      const bool tells = held_out.redundancy >= ClosureSelectionOptions().min_redundancy;
      const bool agrees = held_out.b.dot(held_out.S.ldlt().solve(held_out.b)) < gate_;
      if (!tells && (agrees || in_force)) return std::nullopt;
      return agrees;
    } catch (const Error&) {  // not determined
      return std::nullopt;
    }
  }

  /// Those that more of the others agree with than chance would have; the most supported first.
  std::vector<Passage> rivals_among(const std::vector<Passage>& contradicted) const {
    std::vector<Key> keys;
    for (const Passage& passage : contradicted) {
      keys.push_back(path_[passage.from]);
      keys.push_back(path_[passage.to]);
    }
    sort_unique(keys);
    if (keys.empty()) return {};
    const Eigen::MatrixXd P = marginals_.joint_covariance(keys);
    std::vector<std::pair<std::size_t, Passage>> found;
    for (const Passage& a : contradicted) {
      std::size_t supporters = 0;
      double expected = 0;
      for (const Passage& b : contradicted) {
        if (are_near(a, b)) continue;
        const Circle circle = circle_of(a, b, keys, P);
        expected += chance_of(circle.S);
        if (circle.e.dot(circle.S.ldlt().solve(circle.e)) < gate_) ++supporters;
      }
      if (chance_of_so_many(supporters, expected) * double(contradicted.size()) < kChance) {
        found.emplace_back(supporters, a);
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<Passage> out;
    for (const auto& [supporters, passage] : found) out.push_back(passage);
    return out;
  }

  /// Those that what is trusted does not refute. It may refute a closure if others confirm it along
  /// ways that are as long: on a circle, as on a regular floor, false closures agree with each
  /// other since the stretches between them are alike.
  std::vector<Passage> not_refuted(std::vector<Passage> rivals,
                                   const std::vector<Passage>& agreeing) const {
    if (rivals.empty() || agreeing.size() < kConfirming) return rivals;
    TrustedPath trusted(problem_, values_);
    if (!trusted.tells()) return rivals;
    const auto chi_square = [&](const Passage& p) {
      return trusted.chi_square(*closures_[p.closure]);
    };
    const auto length = [](const Passage& p) {
      return std::max(p.from, p.to) - std::min(p.from, p.to);
    };
    const auto is_refuted = [&](const Passage& rival) {
      std::size_t confirming = 0;
      double worst = gate_;
      for (const Passage& other : agreeing) {
        if (length(other) < length(rival)) continue;
        ++confirming;
        worst = std::max(worst, chi_square(other));
      }
      return confirming >= kConfirming && chi_square(rival) > kFar * worst;
    };
    rivals.erase(std::remove_if(rivals.begin(), rivals.end(), is_refuted), rivals.end());
    return rivals;
  }

  /// The error of a circle through two closures along the map, and its covariance.
  struct Circle {
    typename Pose::Tangent e;
    Jacobian S;
  };

  Circle circle_of(const Passage& a, const Passage& b, const std::vector<Key>& keys,
                   const Eigen::MatrixXd& P) const {
    const RelativePose<Pose> z = *relative_pose<Pose>(*closures_[a.closure]);
    const RelativePose<Pose> w = *relative_pose<Pose>(*closures_[b.closure]);
    const Key ends[] = {path_[a.from], path_[b.from], path_[b.to], path_[a.to]};
    const Pose out = values_.at<Pose>(ends[0]).between(values_.at<Pose>(ends[1]));
    const Pose back = values_.at<Pose>(ends[2]).between(values_.at<Pose>(ends[3]));
    const Jacobian Ad_back = back.inverse().adjoint();
    const Jacobian Ad_out = (w.measured * back).inverse().adjoint();
    Circle circle;
    circle.e = (z.measured.inverse() * out * w.measured * back).log();
    const Jacobian J[] = {-z.measured.inverse().adjoint(), Ad_out, -Ad_back, Jacobian::Identity()};
    circle.S = z.information.inverse() + Ad_back * w.information.inverse() * Ad_back.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        circle.S += J[i] *
                    P.block<Pose::kDim, Pose::kDim>(place(keys, ends[i]), place(keys, ends[j])) *
                    J[j].transpose();
      }
    }
    return circle;
  }

  static Eigen::Index place(const std::vector<Key>& keys, Key key) {
    return Pose::kDim * (std::lower_bound(keys.begin(), keys.end(), key) - keys.begin());
  }

  /// An upper bound of the chance that a closure that may lead anywhere closes a circle: of three
  /// directions alone in space too, since false closures keep to the floor as well.
  double chance_of(const Jacobian& S) const {
    constexpr int kPoint = Pose::Point::RowsAtCompileTime;
    std::vector<double> shares;
    for (int k = 0; k < Pose::kDim; ++k) {
      const double range = k < kPoint ? extent_ : 2 * M_PI;
      shares.push_back(std::min(1.0, 2 * std::sqrt(gate_ * S(k, k)) / range));
    }
    std::sort(shares.rbegin(), shares.rend());
    return shares[0] * shares[1] * shares[2];
  }

  /// Of so many or more, where `expected` are expected.
  static double chance_of_so_many(std::size_t count, double expected) {
    if (count == 0) return 1;
    return std::min(1.0, std::exp(double(count) * std::log(expected) - std::lgamma(count + 1.0)));
  }

  /// The length of the longest side of the map [m].
  double longest_side() const {
    if (path_.empty()) return 0;
    const auto position = [this](Key key) ->
        typename Pose::Point { return values_.at<Pose>(key).translation(); };
    return box_of(path_, position).sizes().maxCoeff();
  }

  std::vector<ClosureAgreement::Stretch> stretches(const std::vector<Passage>& agreeing,
                                                   const std::vector<Passage>& rivals) const {
    const std::size_t length = std::max(kStretch, path_.size() / kMostStretches + 1);
    std::map<std::size_t, std::pair<std::size_t, std::size_t>> counts;
    for (const Passage& passage : agreeing) {
      for (const std::size_t end : {passage.from, passage.to}) ++counts[end / length].first;
    }
    for (const Passage& passage : rivals) {
      for (const std::size_t end : {passage.from, passage.to}) ++counts[end / length].second;
    }
    std::vector<ClosureAgreement::Stretch> out;
    for (const auto& [stretch, count] : counts) {
      out.push_back(
          {stretch * length, ratio(count.first, count.second), count.first + count.second});
    }
    return out;
  }

  const RobustProblem& problem_;
  const Values& values_;
  const std::vector<ContinuousFactorPtr>& closures_;
  const std::vector<bool>& accepted_;
  const ContinuousMarginals marginals_;
  const double gate_;
  std::vector<Key> path_;  // poses, sorted
  double extent_ = 0;      // [m]
};

}  // namespace

ClosureAgreement agreement_of_closures(const RobustProblem& problem, const Values& values,
                                       const std::vector<bool>& accepted, double scale) {
  if (accepted.size() != problem.closures.size()) {
    throw Error("agreement_of_closures: " + std::to_string(accepted.size()) + " decisions on " +
                std::to_string(problem.closures.size()) + " closures");
  }
  const bool is_3d =
      std::any_of(problem.closures.begin(), problem.closures.end(),
                  [](const auto& closure) { return relative_pose<SE3>(*closure).has_value(); });
  if (is_3d) return ClosureJudge<SE3>(problem, values, accepted, scale).judge();
  return ClosureJudge<SE2>(problem, values, accepted, scale).judge();
}

}  // namespace hybrid
