// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/detail/readmission.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "libhybrid/closures/closure_problem.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/linear/information_pattern.h"
#include "libhybrid/solvers/chordal.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

constexpr double kFit = 0.99;            // of true closures, which fit a map as it is
constexpr double kRoughDecrease = 1e-3;  // of solves between macro-steps
/// Operations of a factorisation that any batch may need, about a tenth of a second of one core;
/// one that needs more may need so many times those of the map without it.
constexpr double kCheapFlops = 1e9;
constexpr double kLargestGrowth = 8.0;

/// Closures, those that the trusted factors predict best, that tell the first variance factor: the
/// error of the map shows least in them.
constexpr std::size_t kMostPrecise = 40;
/// Closures whose pairs are tested for agreement, those of most evidence: some 800 pairs.
constexpr std::size_t kMostPaired = 40;

const double kNone = -std::numeric_limits<double>::infinity();

MixtureOptions without_outliers() {
  MixtureOptions options;
  options.null_hypothesis = 0.0;
  return options;
}

}  // namespace

Readmission::Readmission(const RobustProblem& problem, const ClosureSelectionOptions& options)
    : closure_problem_(problem),
      options_(options),
      rough_(options.solver),
      graph_(mixture_graph(problem, without_outliers())),
      pool_(options.solver.threads),
      front_(make_closure_front(problem)),
      values_(problem.initial),
      accepted_(problem.closures.size(), false),
      refused_(accepted_),
      evidence_(accepted_.size(), kNone),
      attainable_(accepted_.size(), std::numeric_limits<double>::infinity()),
      redundancy_(accepted_.size(), 1.0),
      innovation_(accepted_.size()),
      predicted_(accepted_.size()),
      asked_(accepted_.size(), 0) {
  for (const auto& factor : problem.trusted) trusted_normalizer_ += factor->log_normalizer();
  for (const auto& closure : problem.closures) {
    const double normalizer = closure->log_normalizer();
    const MixtureOptions& mixture = options.mixture;
    inlier_constant_.push_back(normalizer - std::log(mixture.inlier_weight));
    outlier_constant_.push_back(
        mixture.null_hypothesis.value_or(normalizer + 0.5 * closure->rows() *
                                                          std::log(mixture.outlier_variance)) -
        std::log(mixture.outlier_weight));
  }
  rough_.relative_decrease = kRoughDecrease;
  model_.degrees = options.degrees_of_freedom;
  model_.gate = options.gate;
  problem_ =
      std::make_unique<Problem>(graph_, values_, to_assignment(accepted_), options.solver.threads,
                                WeakComponents::kUncoupled, Elimination::kPlain);
  state_ = problem_->load(values_);
}

void Readmission::begin() {
  settle(rough_);
  model_.radius = map_radius(values_);
  if (options_.trust_start) trust(closure_problem_.initial);
}

/// Begins anew with the closures that agree with these values, less those that the solution
/// contradicts, and of the new ones those that it would not admit.
void Readmission::trust(const Values& values) {
  const std::vector<bool> before = accepted_;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    const ContinuousFactor& closure = *closure_problem_.closures[k];
    accepted_[k] = 2.0 * closure.cost(values) < gate_quantile(closure.rows());
    refused_[k] = false;
    evidence_[k] = kNone;
    predicted_[k].resize(0, 0);
  }
  drop_ambiguous(values);
  state_ = problem_->load(values);
  settle(rough_);
  for (std::vector<int> contradicted = this->contradicted(&before); !contradicted.empty();
       contradicted = this->contradicted(&before)) {
    contradicted.resize((contradicted.size() + 1) / 2);
    drop(contradicted);
  }
}

/// Solves for the poses given the accepted closures, and updates all that depends on the solution.
void Readmission::settle(const SolverOptions& solver) {
  ++settled_;
  accepted_count_ = static_cast<int>(std::count(accepted_.begin(), accepted_.end(), true));
  problem_->set_assignment(to_assignment(accepted_));
  const SolverReport report = levenberg_marquardt(*problem_, state_, solver);
  iterations_ += report.iterations;
  converged_ = report.status == SolverStatus::kConverged;
  message_ = report.message;
  problem_->linearize(state_);
  problem_->assemble();
  const Undamped undamped = factorize_undamped(*problem_);
  if (!undamped.free.empty()) {
    throw Error("without the closures, " + under_constrained_message(undamped.free) +
                ": closures can only be tested against a connected trajectory");
  }
  if (!undamped.usable) {
    throw Error("without the closures, the trajectory is conditioned too badly to be factorised");
  }
  predictor_ = std::make_unique<InnovationPredictor>(*problem_, state_);
  problem_->store(state_, values_);
  objective_ = problem_->cost(state_) + trusted_normalizer_;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    objective_ += accepted_[k] ? inlier_constant_[k] : outlier_constant_[k];
  }
  assess_accepted();
}

/// Evidence and redundancy of each accepted closure given the others.
void Readmission::assess_accepted() {
  if (accepted_count_ == 0) return;
  const SelectedInverse inverse(problem_->system().cholesky(), pool_);
  std::vector<double> chi_squares;
  std::vector<int> degrees;
  std::vector<Eigen::MatrixXd> covariance(accepted_.size());
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!accepted_[k]) continue;
    const Innovation fit = predictor_->predict_joined(*closure_problem_.closures[k], inverse);
    GivenOthers alone = given_others(fit, true);
    redundancy_[k] = alone.redundancy;
    covariance[k] = std::move(alone.S);
    innovation_[k] = std::move(alone.b);
    if (redundancy_[k] > options_.min_redundancy) {
      chi_squares.push_back(fit.b.squaredNorm() / redundancy_[k]);
      degrees.push_back(static_cast<int>(fit.b.size()));
    }
  }
  if (!chi_squares.empty()) model_.variance_factor = variance_factor(chi_squares, degrees);
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!accepted_[k]) continue;
    weigh(k, covariance[k]);
  }
}

/// Sets the evidence for a closure whose innovation has that covariance.
void Readmission::weigh(std::size_t k, const Eigen::MatrixXd& S) {
  const ContinuousFactor& closure = *closure_problem_.closures[k];
  evidence_[k] = model_.log_ratio(innovation_[k], S, closure);
  attainable_[k] = model_.log_ratio(Eigen::VectorXd::Zero(S.rows()), S, closure);
}

double Readmission::threshold() const {
  return evidence_needed(accepted_.size() - static_cast<std::size_t>(accepted_count_), options_);
}

/// The evidence that closures reach which are told by it: the threshold, with no more than the
/// usual margin.
double Readmission::informative() const {
  return threshold() - options_.margin +
         std::min(options_.margin, ClosureSelectionOptions{}.margin);
}

/// The evidence that one closure needs. One that has too little information to be told by it even
/// where it fits perfectly has to fit as 99 of a hundred true ones do, once these are asked.
double Readmission::needed(std::size_t k) const {
  const double usual = threshold();
  if (!asks_uninformative_ || attainable_[k] > informative()) return usual;
  const int d = closure_problem_.closures[k]->rows();
  return attainable_[k] -
         0.5 * (model_.degrees + d) * std::log1p(chi_square_quantile(kFit, d) / model_.degrees);
}

std::vector<int> Readmission::contradicted(const std::vector<bool>* tested) const {
  std::vector<Candidate> found;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    const bool unchecked = options_.refuse_uncheckable && redundancy_[k] < options_.min_redundancy;
    if (!accepted_[k]) continue;
    const bool is_new = tested != nullptr && !(*tested)[k];
    const double least = needed(k) - (is_new ? 0.0 : 2.0 * options_.margin);
    if (unchecked || evidence_[k] < least) {
      found.push_back({-evidence_[k], static_cast<int>(k)});
    }
  }
  std::sort(found.begin(), found.end());
  std::vector<int> closures;
  for (const Candidate& candidate : found) closures.push_back(candidate.closure);
  return closures;
}

void Readmission::restore(const Snapshot& snapshot) {
  accepted_ = snapshot.accepted;
  state_ = snapshot.state;
  settle(rough_);
}

void Readmission::admit(const std::vector<Candidate>& batch) {
  for (const Candidate& candidate : batch) accepted_[candidate.closure] = true;
  chain();
  settle(rough_);
}

/// Operations of one factorisation of the map with these closures.
double Readmission::work(const std::vector<bool>& accepted) const {
  return order_blocks(information_pattern(graph_, to_assignment(accepted))).flops;
}

bool Readmission::affords(const std::vector<Candidate>& batch) const {
  std::vector<bool> joined = accepted_;
  for (const Candidate& candidate : batch) joined[candidate.closure] = true;
  const double needed = work(joined);
  return needed <= kCheapFlops || needed <= kLargestGrowth * work(accepted_);
}

void Readmission::drop(const std::vector<int>& closures) {
  for (int closure : closures) accepted_[closure] = false;
  for (Eigen::MatrixXd& covariance : predicted_) covariance.resize(0, 0);
  settle(rough_);
}

void Readmission::unfold() {
  const Snapshot folded = snapshot();
  state_ = problem_->load(
      chordal_initialization(factors_in_force(closure_problem_, accepted_), values_));
  settle(rough_);
  if (objective_ > folded.objective) restore(folded);
}

/// Updates innovations, evidence and redundancy of the closures that are not admitted and were not
/// predicted by this map yet; unless `all`, of those that the evidence was for.
void Readmission::predict_others(bool all) {
  std::vector<bool> fresh(accepted_.size(), false);
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (accepted_[k] || refused_[k]) continue;
    if (asked_[k] == settled_ || (!all && evidence_[k] < 0.0)) continue;
    asked_[k] = settled_;
    fresh[k] = true;
    const ContinuousFactor& closure = *closure_problem_.closures[k];
    if (predicted_[k].size() > 0 && accepted_count_ > 0 && is_informative(closure)) {
      const double most =
          model_.largest_log_ratio(predictor_->residual(closure), predicted_[k], closure);
      if (most < threshold() - options_.margin) {
        innovation_[k].resize(0);
        evidence_[k] = most;
        continue;
      }
    }
    GivenOthers alone = given_others(predictor_->predict(closure), false);
    predicted_[k] = std::move(alone.S);
    innovation_[k] = std::move(alone.b);
    redundancy_[k] = alone.redundancy;
  }
  if (accepted_count_ == 0) first_variance_factor();
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (!fresh[k] || innovation_[k].size() == 0) continue;
    weigh(k, predicted_[k]);
  }
}

/// Whether a closure could reach the threshold in a map without errors.
bool Readmission::is_informative(const ContinuousFactor& closure) const {
  return model_.density_ratio(0.0, 0.0, closure) > informative();
}

std::vector<Candidate> Readmission::uninformative() {
  if (asks_uninformative_) return {};
  asks_uninformative_ = true;
  return above_threshold();
}

/// The variance factor before any closure is accepted: from a low quantile over the closures that
/// the trusted factors predict best, for which a share of true ones among them suffices. It is at
/// most one, since a larger one may come from false closures.
void Readmission::first_variance_factor() {
  std::vector<std::pair<double, int>> spread;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (refused_[k] || innovation_[k].size() == 0) continue;
    spread.emplace_back(std::log(predicted_[k].determinant()) +
                            2.0 * closure_problem_.closures[k]->log_normalizer(),
                        static_cast<int>(k));
  }
  std::sort(spread.begin(), spread.end());
  spread.resize(std::min(spread.size(), kMostPrecise));
  std::vector<double> chi_squares;
  std::vector<int> degrees;
  for (const auto& [size, k] : spread) {
    chi_squares.push_back(predicted_[k].llt().matrixL().solve(innovation_[k]).squaredNorm());
    degrees.push_back(static_cast<int>(innovation_[k].size()));
  }
  model_.variance_factor = std::min(1.0, variance_factor(chi_squares, degrees));
}

std::vector<Candidate> Readmission::candidates() {
  predict_others(accepted_count_ == 0);
  std::vector<Candidate> found = above_threshold();
  if (!found.empty() || accepted_count_ == 0) return found;
  predict_others(true);
  return above_threshold();
}

std::vector<Candidate> Readmission::above_threshold() const {
  std::vector<Candidate> found;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (accepted_[k] || refused_[k] || evidence_[k] <= needed(k) || is_excluded(k)) continue;
    if (options_.refuse_uncheckable && redundancy_[k] < options_.min_redundancy) continue;
    found.push_back({evidence_[k], static_cast<int>(k)});
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Candidate> Readmission::all_plausible() {
  predict_others(true);
  std::vector<Candidate> found;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (accepted_[k] || innovation_[k].size() == 0 || is_excluded(k)) continue;
    const double limit = model_.gate * gate_quantile(static_cast<int>(innovation_[k].size()));
    if (predicted_[k].llt().matrixL().solve(innovation_[k]).squaredNorm() <=
        limit * model_.variance_factor) {
      found.push_back({evidence_[k], static_cast<int>(k)});
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Evidence of a, plus that of b given a.
double Readmission::pair_evidence(const Candidate& a, const Candidate& b) {
  const ContinuousFactor& first = *closure_problem_.closures[a.closure];
  const ContinuousFactor& second = *closure_problem_.closures[b.closure];
  const Eigen::MatrixXd cross = predictor_->cross(first, second);
  const Eigen::LLT<Eigen::MatrixXd> llt(predicted_[a.closure]);
  const Eigen::VectorXd b_given_a =
      innovation_[b.closure] - cross.transpose() * llt.solve(innovation_[a.closure]);
  const Eigen::MatrixXd S = predicted_[b.closure] - cross.transpose() * llt.solve(cross);
  return a.evidence + model_.log_ratio(b_given_a, 0.5 * (S + S.transpose()), second);
}

std::vector<Candidate> Readmission::best_pair() {
  std::vector<Candidate> hopeful;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (accepted_[k] || refused_[k] || evidence_[k] < 0.0) continue;
    if (innovation_[k].size() == 0 || is_excluded(k)) continue;
    hopeful.push_back({evidence_[k], static_cast<int>(k)});
  }
  std::sort(hopeful.begin(), hopeful.end());
  hopeful.resize(std::min(hopeful.size(), kMostPaired));
  const double needed = 2.0 * threshold() - options_.margin;
  std::optional<Candidate> best;
  for (std::size_t j = 0; j < hopeful.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const Candidate pair = {pair_evidence(hopeful[i], hopeful[j]), hopeful[i].closure,
                              hopeful[j].closure};
      if (pair.evidence > needed && (!best || pair < *best)) best = pair;
    }
  }
  if (!best) return {};
  return {*best, {best->evidence, best->partner, best->closure}};
}

void Readmission::finish(RobustResult& result) {
  settle(options_.solver);
  for (Eigen::MatrixXd& S : predicted_) S.resize(0, 0);  // the evidence itself, not a bound of it
  std::fill(refused_.begin(), refused_.end(), false);
  predict_others(true);
  weigh_alternatives();
  result.values = values_;
  hybrid::finish(closure_problem_, accepted_, options_.mixture, result);
  result.iterations = iterations_;
  result.variance_factor = model_.variance_factor;
  result.converged = result.converged && converged_;
  result.message = message_;
  result.poses_integrated = true;
  write_evidence(evidence_, redundancy_, closure_problem_.alternatives, options_, result.decisions);
}

}  // namespace hybrid
