// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/posterior_model.h"

#include <algorithm>
#include <unordered_set>

#include "libhybrid/core/infinity.h"
#include "libhybrid/discrete/inference.h"
#include "libhybrid/marginals/detail/outside.h"
#include "libhybrid/marginals/log_determinant.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

/// Graphs of at most this many dimensions are solved whole.
constexpr int kWholeGraph = 32;
/// A scalar whose information, given the others, is below this share of that at the estimate is
/// determined by rounding only; see Exchange.
constexpr double kLeastInformationShare = 1e-10;

/// Whether the variables of a graph have more dimensions than that, at no more cost than that.
bool is_larger(const HybridGraph& graph, const Values& values, int dimensions) {
  std::unordered_set<Key> seen;
  int sum = 0;
  const auto add = [&](const std::vector<Key>& keys) {
    for (Key key : keys) {
      if (seen.insert(key).second) sum += values.type(key).dim;
    }
  };
  const auto add_all = [&](const auto& factors) {
    for (std::uint32_t i = 0; i < factors.capacity() && sum <= dimensions; ++i) {
      if (factors.alive(i)) add(factors[i]->keys());
    }
  };
  add_all(graph.continuous());
  add_all(graph.hybrid());
  return sum > dimensions;
}

template <class T>
void insert_once(std::vector<T>& list, const T& item) {
  if (std::find(list.begin(), list.end(), item) == list.end()) list.push_back(item);
}

/// A pointer that does not own.
HybridFactorPtr borrowed(const HybridFactor& factor) {
  return {HybridFactorPtr(), &factor};
}

}  // namespace

PosteriorModel::PosteriorModel(const HybridGraph& graph, const DiscreteIndex& index,
                               const Estimate& estimate, const std::vector<Key>& selectors,
                               const std::vector<Key>& rest, Laplace laplace,
                               const JointCovariance& covariance, const TableLimits& limits)
    : estimate_(estimate), limits_(limits) {
  for (Key key : selectors) {
    number_.emplace(key, static_cast<int>(selectors_.size()));
    selectors_.push_back(index.at(key).key);
  }
  for (Key key : rest) rest_.push_back(index.at(key).key);
  collect(index);
  if (sites_.empty()) return;
  laplace == Laplace::kLinearized ? linearize(covariance) : reoptimize(graph, covariance);
}

/// Collects the tables at the estimate and the sites of all variables.
void PosteriorModel::collect(const DiscreteIndex& index) {
  std::vector<const Table*> tables;
  std::vector<const HybridFactor*> factors;
  const auto visit = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& key : keys) {
      const DiscreteIndex::Variable& variable = index.at(key.key);
      tables.insert(tables.end(), variable.tables.begin(), variable.tables.end());
      factors.insert(factors.end(), variable.factors.begin(), variable.factors.end());
    }
  };
  visit(selectors_);
  visit(rest_);
  std::unordered_map<const void*, bool> seen;
  for (const Table* table : tables) {
    if (!seen.emplace(table, true).second) continue;
    hold(table->keys());
    add_table(*table);
  }
  for (const HybridFactor* factor : factors) {
    if (!seen.emplace(factor, true).second) continue;
    hold(factor->discrete_keys());
    for (const Table& table : factor->given(estimate_.values)) add_table(table);
    add_site(*factor);
  }
}

void PosteriorModel::hold(const std::vector<DiscreteKey>& keys) {
  for (const DiscreteKey& key : keys) {
    if (number_.count(key.key) != 0 || held_.contains(key.key)) continue;
    if (std::find(rest_.begin(), rest_.end(), key) != rest_.end()) continue;
    held_.set(key.key, estimate_.assignment.at(key.key));
  }
}

void PosteriorModel::add_table(const Table& whole) {
  Table table = condition(whole, held_);
  std::vector<int> variables;
  for (const DiscreteKey& key : table.keys()) {
    const auto it = number_.find(key.key);
    if (it == number_.end()) {
      rest_tables_.push_back(std::move(table));
      return;
    }
    variables.push_back(it->second);
  }
  tables_.push_back({std::move(variables), std::move(table)});
}

/// Adds a site with the factors that the selectors can choose of a hybrid factor.
void PosteriorModel::add_site(const HybridFactor& factor) {
  ChosenFactor chosen;
  Assignment assignment;
  std::vector<DiscreteKey> keys;
  for (const DiscreteKey& key : factor.discrete_keys()) {
    assignment.set(key.key, estimate_.assignment.at(key.key));
  }
  for (const DiscreteKey& key : factor.selectors()) {
    const auto it = number_.find(key.key);
    if (it == number_.end()) continue;
    chosen.selectors.push_back(it->second);
    keys.push_back(key);
  }
  if (keys.empty()) return;
  Site site;
  const ContinuousFactor* present = factor.given(assignment).factor;
  const std::size_t size = joint_size(keys);
  for (std::size_t n = 0; n < size; ++n) {
    set_joint(keys, n, assignment);
    const ContinuousFactor* own = factor.given(assignment).factor;
    insert_once(site.factors, own);
    const auto at = std::find(site.factors.begin(), site.factors.end(), own);
    chosen.factor_of.push_back(static_cast<int>(at - site.factors.begin()));
  }
  const auto at = std::find(site.factors.begin(), site.factors.end(), present);
  site.present = static_cast<int>(at - site.factors.begin());
  factors_.push_back(&factor);
  chosen_.push_back(std::move(chosen));
  sites_.push_back(std::move(site));
}

/// All continuous variables of the sites.
std::vector<Key> PosteriorModel::touched() const {
  std::vector<Key> keys;
  std::unordered_map<Key, bool> seen;
  for (const Site& site : sites_) {
    for (const ContinuousFactor* factor : site.factors) {
      if (factor == nullptr) continue;
      for (Key key : factor->keys()) {
        if (seen.emplace(key, true).second) keys.push_back(key);
      }
    }
  }
  return keys;
}

void PosteriorModel::linearize(const JointCovariance& covariance) {
  const std::vector<Key> keys = touched();
  const Eigen::MatrixXd joint = keys.empty() ? Eigen::MatrixXd() : covariance(keys);
  if (joint.size() == 0 && !keys.empty()) {
    under_constrained_ = keys;
    return;
  }
  exchange_ = std::make_unique<Exchange>(JointGaussian(keys, joint, estimate_.values), sites_);
}

void PosteriorModel::reoptimize(const HybridGraph& graph, const JointCovariance& covariance) {
  Assignment assignment = held_;
  for (const DiscreteKey& key : selectors_) {
    assignment.set(key.key, estimate_.assignment.at(key.key));
  }
  for (const DiscreteKey& key : rest_) {
    assignment.set(key.key, estimate_.assignment.at(key.key));
  }
  const HybridGraph* whole = &graph;
  if (is_larger(graph, estimate_.values, kWholeGraph)) {
    const std::vector<Key> keys = touched();
    for (const HybridFactor* factor : factors_) graph_.add(borrowed(*factor));
    if (!keys.empty()) {
      Eigen::MatrixXd joint = covariance(keys);
      if (joint.size() == 0) {
        under_constrained_ = keys;
        return;
      }
      const JointGaussian gaussian(keys, std::move(joint), estimate_.values);
      for (Key key : keys) {
        const int dim = estimate_.values.type(key).dim;
        variances_.emplace_back(
            key, gaussian.covariance.diagonal().segment(gaussian.place.at(key), dim));
      }
      try {
        ContinuousFactorPtr outside = outside_prior(gaussian, sites_);
        if (outside != nullptr) graph_.add(std::move(outside));
      } catch (const Error&) {  // of so large rounding errors that nothing can be told
        under_constrained_ = keys;
        return;
      }
    }
    whole = &graph_;
  } else {
    assignment = estimate_.assignment;
  }
  held_ = std::move(assignment);
  problem_ = std::make_unique<Problem>(*whole, estimate_.values, held_, 1, WeakComponents::kCoupled,
                                       Elimination::kPlain);
  start_ = problem_->load(estimate_.values);
}

int PosteriorModel::joint(const std::vector<int>& variables, const std::vector<int>& values) const {
  int index = 0;
  for (int v : variables) index = index * selectors_[v].cardinality + values[v];
  return index;
}

const PosteriorModel::Weight& PosteriorModel::at(const std::vector<int>& values) {
  const auto [it, is_new] = known_.emplace(
      std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(int)),
      Weight());
  Weight& weight = it->second;
  if (!is_new) return weight;
  const std::optional<double> change =
      discrete_weight(values, weight) ? log_change(values) : std::nullopt;
  weight.log = change ? weight.log + *change : -kInfinity;
  return weight;
}

/// The weight by the tables, with the rest summed out; false if it is impossible.
bool PosteriorModel::discrete_weight(const std::vector<int>& values, Weight& weight) const {
  double cost = 0.0;
  for (const SelectorTable& t : tables_) cost += t.table.costs()[joint(t.variables, values)];
  if (cost == kInfinity) return false;
  weight.log = -cost;
  if (rest_.empty()) return true;
  Assignment assignment;
  for (std::size_t v = 0; v < values.size(); ++v) assignment.set(selectors_[v].key, values[v]);
  std::vector<Table> given;
  given.reserve(rest_tables_.size());
  std::vector<const Table*> tables;
  for (const Table& table : rest_tables_) {
    given.push_back(condition(table, assignment));
    tables.push_back(&given.back());
  }
  DiscreteOptions options;
  static_cast<TableLimits&>(options) = limits_;
  options.local_search_when_too_large = false;
  if (solve_discrete(tables, options).cost == kInfinity) return false;
  const DiscreteMarginals marginals = discrete_marginals(tables, limits_);
  weight.log += marginals.log_partition();
  for (const DiscreteKey& key : rest_) {
    const auto p = marginals.at(key.key);
    weight.rest.insert(weight.rest.end(), p.data(), p.data() + p.size());
  }
  return true;
}

std::optional<double> PosteriorModel::log_change(const std::vector<int>& values) {
  if (sites_.empty()) return 0.0;
  if (problem_ != nullptr) return solve(values);
  if (exchange_ == nullptr) return std::nullopt;
  std::vector<int> numbers;
  for (const ChosenFactor& chosen : chosen_) {
    numbers.push_back(chosen.factor_of[joint(chosen.selectors, values)]);
  }
  const std::optional<double> change = exchange_->log_change(numbers);
  if (!change && under_constrained_.empty()) {
    for (std::size_t k = 0; k < sites_.size(); ++k) {
      if (numbers[k] == sites_[k].present) continue;
      for (Key key : factors_[k]->keys()) insert_once(under_constrained_, key);
    }
  }
  return change;
}

/// Optimises the continuous variables from the estimate on; returns the log evidence, empty if they
/// are undetermined.
std::optional<double> PosteriorModel::solve(const std::vector<int>& values) {
  for (std::size_t v = 0; v < values.size(); ++v) held_.set(selectors_[v].key, values[v]);
  problem_->set_assignment(held_);
  SolverOptions options;
  options.relative_decrease = 1e-9;
  options.threads = 1;
  Problem::State state = start_;
  const double before = problem_->cost(state);
  levenberg_marquardt(*problem_, state, options);
  const double after = problem_->linearize(state);
  const LogDeterminant hessian = log_determinant(*problem_);
  if (!hessian.under_constrained.empty()) {
    if (under_constrained_.empty()) under_constrained_ = hessian.under_constrained;
    return std::nullopt;
  }
  for (std::size_t k = 0; k < variances_.size(); ++k) {
    const int block = problem_->block(variances_[k].first);
    for (int i = 0; i < variances_[k].second.size(); ++i) {
      const double root = problem_->system().pivot_root(problem_->system().start(block) + i);
      if (root * root * variances_[k].second[i] > kLeastInformationShare) continue;
      if (under_constrained_.empty()) under_constrained_ = {variances_[k].first};
      return std::nullopt;
    }
  }
  return before - after - 0.5 * hessian.value;
}

std::vector<int> PosteriorModel::present() const {
  std::vector<int> values;
  for (const DiscreteKey& key : selectors_) {
    values.push_back(estimate_.assignment.at(key.key));
  }
  return values;
}

std::vector<std::pair<int, int>> PosteriorModel::pairs() const {
  std::vector<std::pair<int, int>> pairs;
  const auto add = [&](const std::vector<int>& variables) {
    for (std::size_t i = 0; i < variables.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const auto [a, b] = std::minmax(variables[i], variables[j]);
        insert_once(pairs, {a, b});
      }
    }
  };
  for (const SelectorTable& t : tables_) add(t.variables);
  for (const ChosenFactor& chosen : chosen_) add(chosen.selectors);
  return pairs;
}

}  // namespace hybrid
