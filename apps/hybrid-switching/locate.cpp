// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/locate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/marginals/posterior.h"
#include "libhybrid/solvers/alternating.h"

namespace hybrid {
namespace {

using AnchoredRange = Range<SE2, Eigen::Vector2d>;

constexpr int kHeadings = 8;        ///< starts of the solver; the first heading is unknown
constexpr double kAnyAngle = 10.0;  ///< sigma of the first heading [rad]
constexpr double kAnchorSigma = 1e-4;
constexpr int kMaxRounds = 50;
constexpr double kLearnt = 1e-4;      ///< largest change of a parameter at convergence [m]
constexpr double kLeastSigma = 0.02;  ///< of a mode [m]
constexpr double kPriorCount = 2.0;   ///< weight of the initial guess of a mode, in observations

std::map<int, Eigen::Vector2d> anchors_of(const RangeLog& log) {
  std::map<int, Eigen::Vector2d> anchors;
  for (const AnchorRange& r : log.ranges) anchors[r.anchor_id] = r.anchor;
  return anchors;
}

/// Centroid of the anchors.
Eigen::Vector2d centroid(const RangeLog& log) {
  const auto anchors = anchors_of(log);
  Eigen::Vector2d middle(0, 0);
  for (const auto& [id, p] : anchors) middle += p / static_cast<double>(anchors.size());
  return middle;
}

/// The log with another origin; far from the origin, rounding spoils the sums of the solver.
RangeLog with_origin(RangeLog log, const Eigen::Vector2d& origin) {
  for (AnchorRange& r : log.ranges) r.anchor -= origin;
  return log;
}

/// The problem without ranges: motions and anchors. The centroid of the anchors is the origin.
class RangeProblem {
 public:
  explicit RangeProblem(const RangeLog& log) : log_(log), anchors_(anchors_of(log)) {
    for (const AnchorRange& r : log.ranges) times_.push_back(r.time);
    for (const WheelSpeeds& w : log.odometry) times_.push_back(w.time);
    sort_unique(times_);
    add_prior();
    add_motion();
  }

  const std::vector<double>& times() const { return times_; }
  const HybridGraph& base() const { return base_; }

  Key pose(double time) const {
    const auto it = std::lower_bound(times_.begin(), times_.end(), time);
    return {key_letter::kPose, static_cast<std::uint64_t>(it - times_.begin())};
  }
  static Key anchor(int id) { return {key_letter::kAnchor, static_cast<std::uint64_t>(id)}; }

  /// Dead reckoning from the centroid of the anchors.
  Values start(double heading) const {
    Values values;
    for (const auto& [id, p] : anchors_) values.insert(anchor(id), p);
    SE2 T(0, 0, heading);
    for (std::size_t i = 0; i < times_.size(); ++i) {
      if (i > 0) T = T * steps_[i - 1];
      values.insert(Key(key_letter::kPose, i), T);
    }
    return values;
  }

  HybridGraph graph_without_ranges() const {
    HybridGraph graph = base_;
    for (const auto& [id, p] : anchors_) {
      graph.emplace<Prior<Eigen::Vector2d>>(anchor(id), p, Noise::isotropic(2, kAnchorSigma));
    }
    return graph;
  }

 private:
  /// The first pose is at the centroid within the extent of the anchors, or the longest range.
  void add_prior() {
    double extent = std::sqrt(log_.ranges.front().variance);
    for (const auto& [id, p] : anchors_) extent = std::max(extent, 2.0 * p.norm());
    for (const AnchorRange& r : log_.ranges) extent = std::max(extent, r.range);
    base_.emplace<Prior<SE2>>(Key(key_letter::kPose, 0), SE2(),
                              Noise::diagonal(Eigen::Vector3d(extent, extent, kAnyAngle)));
  }

  void add_motion() {
    std::size_t row = 0;
    for (std::size_t i = 0; i + 1 < times_.size(); ++i) {
      while (row + 1 < log_.odometry.size() && log_.odometry[row + 1].time <= times_[i]) ++row;
      const WheelSpeeds& w = log_.odometry[row];
      const double dt = times_[i + 1] - times_[i];
      const double forward = 0.5 * (w.right + w.left) * dt,
                   turn = (w.right - w.left) / (2.0 * w.half_base) * dt;
      const double wheels = std::sqrt(w.variance_right + w.variance_left);
      steps_.push_back(SE2::exp({forward, w.side * dt, turn}));
      const Eigen::Vector3d sigmas(0.5 * wheels * dt, std::sqrt(w.variance_side) * dt,
                                   wheels / (2.0 * w.half_base) * dt);
      base_.emplace<BetweenSE2>(Key(key_letter::kPose, i), Key(key_letter::kPose, i + 1),
                                steps_.back(), Noise::diagonal(sigmas));
    }
  }

  const RangeLog& log_;
  std::map<int, Eigen::Vector2d> anchors_;
  std::vector<double> times_;
  std::vector<SE2> steps_;
  HybridGraph base_;
};

ContinuousFactorPtr range_factor(const RangeProblem& problem, const AnchorRange& r, double bias,
                                 double sigma, Loss loss = {}) {
  return std::make_shared<AnchoredRange>(problem.pose(r.time), RangeProblem::anchor(r.anchor_id),
                                         std::max(0.0, r.range - bias), Noise::isotropic(1, sigma),
                                         Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), loss);
}

/// The best result over several initial headings.
AlternatingResult solve(const RangeProblem& problem, const HybridGraph& graph,
                        const Assignment& assignment) {
  AlternatingResult best;
  for (int k = 0; k < kHeadings; ++k) {
    AlternatingResult result =
        alternate(graph, {problem.start(2.0 * M_PI * k / kHeadings), assignment});
    if (k == 0 || result.report.objective < best.report.objective) best = std::move(result);
  }
  return best;
}

DiscreteKey range_mode(std::size_t i) {
  return {Key(key_letter::kMotionMode, i), 2};
}

/// The graph with ranges as mixtures, and a Markov chain of modes per anchor.
HybridGraph mode_graph(const RangeProblem& problem, const RangeLog& log, const RangeModes& modes) {
  HybridGraph graph = problem.graph_without_ranges();
  std::map<int, std::vector<DiscreteKey>> chains;
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    const AnchorRange& r = log.ranges[i];
    std::vector<MixtureComponent> components;
    for (int m = 0; m < 2; ++m) {
      components.push_back({range_factor(problem, r, modes.bias[m], modes.sigma[m])});
    }
    graph.add(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{range_mode(i)}, std::move(components)));
    chains[r.anchor_id].push_back(range_mode(i));
  }
  for (const auto& [id, keys] : chains) {
    for (Table& table : chain_tables(modes.chain, keys)) graph.add(std::move(table));
  }
  return graph;
}

double predicted_range(const RangeProblem& problem, const AnchorRange& r, const Values& values) {
  return (values.at<SE2>(problem.pose(r.time)).translation() - r.anchor).norm();
}

/// One round of expectation-maximisation at an estimate: weighted means and variances, and expected
/// transitions (by the product of successive marginals).
RangeModes learn(const RangeProblem& problem, const RangeLog& log, const HybridGraph& graph,
                 const Values& values, const RangeModes& guess, const RangeModes& now) {
  const DiscreteMarginals marginals = discrete_marginals(graph, values);
  MarkovCounts counts(2);
  std::map<int, Eigen::VectorXd> before;
  Eigen::Array2d weight = Eigen::Array2d::Constant(kPriorCount), sum, squares;
  for (int m = 0; m < 2; ++m) sum[m] = kPriorCount * guess.bias[m];
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    const AnchorRange& r = log.ranges[i];
    const Eigen::VectorXd p = marginals.at(range_mode(i).key);
    weight += p.array();
    sum += p.array() * (r.range - predicted_range(problem, r, values));
    Eigen::VectorXd& last = before[r.anchor_id];
    if (last.size() == 0) counts.starts += p;
    if (last.size() != 0) counts.changes += last * p.transpose();
    last = p;
  }
  RangeModes out = now;
  for (int m = 0; m < 2; ++m) out.bias[m] = sum[m] / weight[m];
  for (int m = 0; m < 2; ++m) squares[m] = kPriorCount * guess.sigma[m] * guess.sigma[m];
  for (std::size_t i = 0; i < log.ranges.size(); ++i) {
    const AnchorRange& r = log.ranges[i];
    const double e = r.range - predicted_range(problem, r, values);
    const auto p = marginals.at(range_mode(i).key);
    for (int m = 0; m < 2; ++m) squares[m] += p[m] * (e - out.bias[m]) * (e - out.bias[m]);
  }
  for (int m = 0; m < 2; ++m) {
    out.sigma[m] = std::max(kLeastSigma, std::sqrt(squares[m] / weight[m]));
  }
  out.chain = counts.chain(1.0);
  return out;
}

/// Probability of the second mode of every range, with the path integrated out.
std::vector<double> second_mode_probabilities(const RangeLog& log, const HybridGraph& graph,
                                              const Estimate& estimate) {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < log.ranges.size(); ++i) keys.push_back(range_mode(i).key);
  const AssignmentPosterior posterior = posterior_marginals(graph, estimate, keys);
  std::vector<double> probabilities;
  for (Key key : keys) probabilities.push_back(posterior.at(key).p[1]);
  return probabilities;
}

Located make_located(const std::string& method, const RangeProblem& problem,
                     const AlternatingResult& result, const Eigen::Vector2d& origin) {
  Located out;
  out.method = method;
  out.times = problem.times();
  out.objective = result.report.objective;
  for (std::size_t i = 0; i < out.times.size(); ++i) {
    const SE2& T = result.estimate.values.at<SE2>(Key(key_letter::kPose, i));
    out.path.emplace_back(origin + T.translation(), T.rotation());
  }
  return out;
}

}  // namespace

Located locate(const RangeLog& world_log, const std::string& method, Loss loss) {
  const auto start = std::chrono::steady_clock::now();
  const Eigen::Vector2d origin = centroid(world_log);
  const RangeLog log = with_origin(world_log, origin);
  const RangeProblem problem(log);
  HybridGraph graph = problem.graph_without_ranges();
  for (const AnchorRange& r : log.ranges) {
    graph.add(range_factor(problem, r, 0.0, std::sqrt(r.variance), loss));
  }
  Located out = make_located(method, problem, solve(problem, graph, {}), origin);
  out.seconds = seconds_since(start);
  return out;
}

Located locate_with_modes(const RangeLog& world_log) {
  const auto start = std::chrono::steady_clock::now();
  const Eigen::Vector2d origin = centroid(world_log);
  const RangeLog log = with_origin(world_log, origin);
  const RangeProblem problem(log);
  const double sigma = std::sqrt(log.ranges.front().variance);
  const RangeModes guess{{0.0, 2.0 * sigma}, {sigma, 2.0 * sigma}, sticky_chain(2, 0.8)};
  RangeModes modes = guess;
  Assignment assignment;
  for (std::size_t i = 0; i < log.ranges.size(); ++i) assignment.set(range_mode(i).key, 0);
  HybridGraph graph = mode_graph(problem, log, modes);
  AlternatingResult result = solve(problem, graph, assignment);
  int rounds = 0;
  for (double change = 1.0; change > kLearnt && rounds < kMaxRounds; ++rounds) {
    const RangeModes learnt = learn(problem, log, graph, result.estimate.values, guess, modes);
    change = 0.0;
    for (int m = 0; m < 2; ++m) {
      change = std::max({change, std::abs(learnt.bias[m] - modes.bias[m]),
                         std::abs(learnt.sigma[m] - modes.sigma[m])});
    }
    modes = learnt;
    graph = mode_graph(problem, log, modes);
    result = alternate(graph, result.estimate);
  }
  Located out = make_located("modes", problem, result, origin);
  out.non_line_of_sight = second_mode_probabilities(log, graph, result.estimate);
  out.modes = modes;
  out.rounds = rounds;
  out.seconds = seconds_since(start);
  return out;
}

std::vector<double> position_errors(const Located& located, const std::vector<TruePoint>& truth) {
  std::vector<double> errors;
  for (const TruePoint& p : truth) {
    const auto it = std::lower_bound(located.times.begin(), located.times.end(), p.time - 1e-3);
    if (it == located.times.end() || std::abs(*it - p.time) > 1e-3) continue;
    errors.push_back((located.path[it - located.times.begin()].translation() - p.position).norm());
  }
  return errors;
}

}  // namespace hybrid
