// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/inference.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/discrete/detail/local_search.h"
#include "libhybrid/discrete/detail/variable_elimination.h"
#include "libhybrid/discrete/impossible.h"

namespace hybrid {
namespace {

std::vector<Key> keys_of(const DiscreteGraph& graph, const std::vector<int>& variables) {
  std::vector<Key> keys;
  for (const int v : variables) keys.push_back(graph.variables()[v].key);
  return keys;
}

std::string describe(const DiscreteGraph& graph, const TooLarge& failure,
                     const TableLimits& limits) {
  std::ostringstream text;
  text << "exact discrete inference needs " << failure.entries << " table entries over "
       << names_of(keys_of(graph, failure.variables)) << ", beyond the limits of "
       << limits.max_table << " (max_table) and " << limits.max_total
       << " for all tables (max_total)";
  return text.str();
}

/// Whether a cost is lower by more than rounding, so that equal costs keep the incumbent.
bool is_lower(double cost, double than) {
  return cost < than && !(cost >= than - 1e-12 * std::max(1.0, std::abs(than)));
}

/// One solve: the incumbent values and the best ones found.
class MinimumCost {
 public:
  MinimumCost(const DiscreteGraph& graph, const DiscreteOptions& options,
              std::vector<int> incumbent, DiscreteReport& report)
      : graph_(graph),
        options_(options),
        incumbent_(std::move(incumbent)),
        best_(incumbent_),
        report_(report) {}

  const std::vector<int>& run() {
    for (std::size_t t = 0; t < graph_.tables().size(); ++t) {
      if (graph_.scope(t).size() == 0) report_.cost += graph_.cost(t, best_);
    }
    int singles = 0;
    for (int c = 0; c < graph_.component_count(); ++c) {
      if (graph_.component_variables(c).size() > 1) continue;
      solve_single(c);
      ++singles;
    }
    if (singles < graph_.component_count()) solve_components();
    return best_;
  }

 private:
  void solve_single(int component);
  void solve_components();
  double settle(int component);
  double cost(int component, const std::vector<int>& values) const {
    double sum = 0.0;
    for (int t : graph_.component_tables(component)) sum += graph_.cost(t, values);
    return sum;
  }

  const DiscreteGraph& graph_;
  const DiscreteOptions& options_;
  const std::vector<int> incumbent_;
  std::vector<int> best_;
  std::vector<double> sum_;
  DiscreteReport& report_;
};

void MinimumCost::solve_single(int component) {
  const int v = graph_.component_variables(component)[0];
  const IntSpan tables = graph_.component_tables(component);
  const double* costs = graph_.tables()[tables[0]]->costs().data();
  const int n = graph_.cardinality(v);
  if (tables.size() > 1) {
    sum_.assign(costs, costs + n);
    for (int i = 1; i < tables.size(); ++i) {
      const std::vector<double>& more = graph_.tables()[tables[i]]->costs();
      for (int j = 0; j < n; ++j) sum_[j] += more[j];
    }
    costs = sum_.data();
  }
  int best = static_cast<int>(std::min_element(costs, costs + n) - costs);
  if (incumbent_[v] >= 0 && !is_lower(costs[best], costs[incumbent_[v]])) best = incumbent_[v];
  best_[v] = best;
  report_.cost += costs[best];
  if (costs[best] == kInfinity) report_.impossible.push_back(graph_.variables()[v].key);
}

void MinimumCost::solve_components() {
  const JunctionForest forest = make_junction_forest(graph_, options_, false);
  if (!forest.too_large.empty() && !options_.local_search_when_too_large) {
    throw Error(describe(graph_, forest.too_large[0], options_) +
                "; raise the limits or allow local search");
  }
  VariableElimination elimination(graph_, forest);
  elimination.minimize(best_);
  for (const std::vector<int>& clique : elimination.impossible()) {
    for (int v : clique) report_.impossible.push_back(graph_.variables()[v].key);
  }
  for (const TooLarge& failure : forest.too_large) {
    report_.exact = false;
    for (int v : graph_.component_variables(failure.component)) best_[v] = std::max(best_[v], 0);
    local_search(graph_, failure.component, options_.max_sweeps, best_);
  }
  for (int c = 0; c < graph_.component_count(); ++c) {
    if (graph_.component_variables(c).size() > 1) report_.cost += settle(c);
  }
}

// Restores the incumbent of a whole component unless its cost fell; returns its cost.
double MinimumCost::settle(int component) {
  const double found = cost(component, best_);
  const IntSpan variables = graph_.component_variables(component);
  bool moved = false;
  for (int v : variables) {
    if (incumbent_[v] < 0) return found;
    moved = moved || incumbent_[v] != best_[v];
  }
  if (!moved) return found;
  const double before = cost(component, incumbent_);
  if (is_lower(found, before)) return found;
  for (int v : variables) best_[v] = incumbent_[v];
  return before;
}

/// Calibrates the junction forest of a graph, or throws.
double calibrate(const DiscreteGraph& graph, const JunctionForest& forest,
                 const TableLimits& limits, VariableElimination& elimination) {
  if (!forest.too_large.empty()) {
    throw Error(describe(graph, forest.too_large[0], limits) + "; raise the limits");
  }
  const double log_sum = elimination.calibrate();
  if (!elimination.impossible().empty()) {
    throw Error(no_joint_value(keys_of(graph, elimination.impossible()[0])));
  }
  return log_sum;
}

}  // namespace

DiscreteReport update_assignment(const std::vector<const Table*>& tables,
                                 const DiscreteOptions& options, Assignment& assignment) {
  const DiscreteGraph graph(tables);
  std::vector<int> incumbent(graph.size());
  for (int v = 0; v < graph.size(); ++v) {
    incumbent[v] = assignment.find(graph.variables()[v].key);
    if (incumbent[v] >= graph.cardinality(v) || incumbent[v] < 0) incumbent[v] = -1;
  }
  DiscreteReport report;
  MinimumCost solver(graph, options, incumbent, report);
  const std::vector<int>& best = solver.run();
  for (int v = 0; v < graph.size(); ++v) {
    if (best[v] == incumbent[v]) continue;
    assignment.set(graph.variables()[v].key, best[v]);
    report.changed.push_back(graph.variables()[v].key);
  }
  return report;
}

DiscreteSolution solve_discrete(const std::vector<const Table*>& tables,
                                const DiscreteOptions& options, const Assignment* incumbent) {
  DiscreteSolution solution;
  if (incumbent != nullptr) {
    for (const Table* table : tables) {
      for (const DiscreteKey& key : table->keys()) {
        const int value = incumbent->find(key.key);
        if (value >= 0) solution.assignment.set(key.key, value);
      }
    }
  }
  static_cast<DiscreteReport&>(solution) = update_assignment(tables, options, solution.assignment);
  return solution;
}

Eigen::Map<const Eigen::VectorXd> DiscreteMarginals::at(Key key) const {
  const auto it = places_.find(key);
  if (it == places_.end()) throw Error("discrete variable " + to_string(key) + " has no marginal");
  return {probabilities_.data() + it->second.begin, it->second.size};
}

DiscreteMarginals discrete_marginals(const std::vector<const Table*>& tables,
                                     const TableLimits& limits) {
  const DiscreteGraph graph(tables);
  const JunctionForest forest = make_junction_forest(graph, limits, true);
  VariableElimination elimination(graph, forest);
  DiscreteMarginals result;
  result.log_partition_ = calibrate(graph, forest, limits, elimination);
  for (const Table* table : tables) {
    if (table->keys().empty() && !table->costs().empty()) {
      result.log_partition_ -= table->costs()[0];
    }
  }
  result.places_.reserve(graph.size());
  for (int v = 0; v < graph.size(); ++v) {
    const std::vector<double> p = elimination.marginal({v});
    result.places_.emplace(
        graph.variables()[v].key,
        DiscreteMarginals::Place{result.probabilities_.size(), graph.cardinality(v)});
    result.probabilities_.insert(result.probabilities_.end(), p.begin(), p.end());
  }
  return result;
}

TableMarginals table_marginals(const std::vector<const Table*>& tables, const TableLimits& limits) {
  const DiscreteGraph graph(tables);
  const JunctionForest forest = make_junction_forest(graph, limits, true);
  VariableElimination elimination(graph, forest);
  TableMarginals result;
  result.log_partition = calibrate(graph, forest, limits, elimination);
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const IntSpan scope = graph.scope(static_cast<int>(t));
    if (scope.size() == 0) {
      if (!tables[t]->costs().empty()) result.log_partition -= tables[t]->costs()[0];
      result.tables.push_back({1.0});
      continue;
    }
    result.tables.push_back(elimination.marginal({scope.begin(), scope.end()}));
  }
  return result;
}

std::vector<double> joint_marginal(const std::vector<const Table*>& tables,
                                   const std::vector<Key>& variables, const TableLimits& limits) {
  const DiscreteGraph given(tables);
  std::vector<DiscreteKey> keys;
  for (Key key : variables) {
    const auto& all = given.variables();
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const DiscreteKey& other) { return other.key == key; });
    if (found == all.end()) throw Error("discrete variable " + to_string(key) + " is in no table");
    keys.push_back(*found);
  }
  const std::size_t size = joint_size(keys);
  if (size > limits.max_table) {
    throw Error("the joint marginal of " + std::to_string(keys.size()) + " variables has " +
                std::to_string(size) + " entries, beyond the limit of " +
                std::to_string(limits.max_table));
  }
  // A table of zero costs makes the variables share a clique.
  const Table together(keys, std::vector<double>(size, 0.0));
  std::vector<const Table*> extended = tables;
  extended.push_back(&together);
  const DiscreteGraph graph(std::move(extended));
  const JunctionForest forest = make_junction_forest(graph, limits, true);
  VariableElimination elimination(graph, forest);
  calibrate(graph, forest, limits, elimination);
  const IntSpan scope = graph.scope(static_cast<int>(tables.size()));
  return elimination.marginal({scope.begin(), scope.end()});
}

}  // namespace hybrid
