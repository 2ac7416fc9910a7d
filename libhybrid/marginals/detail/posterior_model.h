// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/discrete/junction_forest.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/marginals/detail/discrete_index.h"
#include "libhybrid/marginals/detail/exchange.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// The log evidence, up to a common constant, of the joint values of some variables that choose
/// components ("selectors"). All other selectors are held at the estimate; variables that choose
/// nothing ("rest") are summed out.
class PosteriorModel {
 public:
  /// How the continuous variables are integrated out.
  enum class Laplace {
    kReoptimized,  ///< at their optimum for each joint value
    kLinearized    ///< with the factors linearised at the estimate
  };

  /// `rest` must hold all variables that choose nothing and are connected with the selectors by
  /// tables or hybrid factors.
  PosteriorModel(const HybridGraph& graph, const DiscreteIndex& index, const Estimate& estimate,
                 const std::vector<Key>& selectors, const std::vector<Key>& rest, Laplace laplace,
                 const JointCovariance& covariance, const TableLimits& limits);

  struct Weight {
    double log = 0.0;          ///< -infinity if impossible or undetermined
    std::vector<double> rest;  ///< marginals of the rest, one variable after the other
  };
  /// The weight of joint values of the selectors, computed once for each.
  const Weight& at(const std::vector<int>& values);

  const std::vector<DiscreteKey>& selectors() const { return selectors_; }
  const std::vector<DiscreteKey>& rest() const { return rest_; }
  /// The values of the selectors in the estimate.
  std::vector<int> present() const;
  /// Pairs of selectors, by index, that share a table or a factor.
  std::vector<std::pair<int, int>> pairs() const;
  /// Continuous variables that some joint value asked for leaves undetermined.
  const std::vector<Key>& under_constrained() const { return under_constrained_; }

 private:
  struct SelectorTable {  // over selectors only
    std::vector<int> variables;
    Table table;
  };
  struct ChosenFactor {  // the choice among the factors of a hybrid factor
    std::vector<int> selectors;
    std::vector<int> factor_of;  // by joint value of these: index in the site
  };

  void collect(const DiscreteIndex& index);
  void hold(const std::vector<DiscreteKey>& keys);
  void add_table(const Table& table);
  void add_site(const HybridFactor& factor);
  std::vector<Key> touched() const;
  void linearize(const JointCovariance& covariance);
  void reoptimize(const HybridGraph& graph, const JointCovariance& covariance);
  bool discrete_weight(const std::vector<int>& values, Weight& weight) const;
  std::optional<double> log_change(const std::vector<int>& values);
  std::optional<double> solve(const std::vector<int>& values);
  int joint(const std::vector<int>& variables, const std::vector<int>& values) const;

  const Estimate& estimate_;
  TableLimits limits_;
  std::vector<DiscreteKey> selectors_, rest_;
  std::unordered_map<Key, int> number_;  // index of a selector
  Assignment held_;                      // values of the other variables of the tables and factors
  std::vector<SelectorTable> tables_;
  std::vector<Table> rest_tables_;
  std::vector<const HybridFactor*> factors_;  // whose component the selectors choose
  std::vector<ChosenFactor> chosen_;
  std::vector<Site> sites_;

  std::unique_ptr<Exchange> exchange_;  // of kLinearized; problem_ is of kReoptimized
  HybridGraph graph_;
  std::unique_ptr<Problem> problem_;
  Problem::State start_;
  std::vector<std::pair<Key, Eigen::VectorXd>> variances_;  // at the estimate
  std::unordered_map<std::string, Weight> known_;
  std::vector<Key> under_constrained_;
};

}  // namespace hybrid
