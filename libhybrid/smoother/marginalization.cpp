// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/marginalization.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "libhybrid/core/pivoted_cholesky.h"
#include "libhybrid/core/rank_update.h"
#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/smoother/detail/located.h"

namespace hybrid {
namespace {

/// A pivot below this share of its diagonal entry is rounding error: nothing is known of a
/// direction.
constexpr double kPivotTolerance = 1e-13;

/// The dense system of the factors that go: the variables to go first, then the separator, then the
/// right-hand side.
struct System {
  std::vector<Key> keys;
  std::unordered_map<Key, int> row;
  std::unordered_set<Key> located;  // variables with a place in the map
  int gone = 0;                     // rows of the variables to go
  int size = 0;
  Eigen::MatrixXd H;  // [J r]'[J r], lower triangle

  void append(Key key, int dim) {
    if (!row.emplace(key, size).second) return;
    keys.push_back(key);
    size += dim;
  }
  void add(const ContinuousFactor& factor, const Values& values);
};

void System::add(const ContinuousFactor& factor, const Values& values) {
  const auto x = gather(factor.keys(), factor.types(), values);
  Eigen::MatrixXd A(factor.rows(), factor.cols() + 1);
  factor.linearize(x.data(), A.rightCols(1).data(), A.data());
  const auto* prior = dynamic_cast<const LinearPrior*>(&factor);
  const std::vector<bool> has_place =
      prior != nullptr ? prior->located() : located_variables(factor, x.data(), A);
  std::vector<int> place;
  for (std::size_t i = 0; i < factor.keys().size(); ++i) {
    if (has_place[i]) located.insert(factor.keys()[i]);
    const int first = row.at(factor.keys()[i]);
    for (int k = 0; k < factor.types()[i].dim; ++k) place.push_back(first + k);
  }
  place.push_back(size);
  const Eigen::MatrixXd S = A.transpose() * A;
  for (std::size_t j = 0; j < place.size(); ++j) {
    for (std::size_t i = j; i < place.size(); ++i)
      H(std::max(place[i], place[j]), std::min(place[i], place[j])) += S(i, j);
  }
}

std::vector<const ContinuousFactor*> active_factors(const HybridGraph& graph,
                                                    const Assignment& assignment,
                                                    const std::vector<Handle>& handles) {
  std::vector<const ContinuousFactor*> factors;
  for (Handle handle : handles) {
    if (handle.kind == FactorKind::kContinuous) {
      factors.push_back(graph.continuous().at(handle).get());
    } else if (handle.kind == FactorKind::kHybrid) {
      const Component component = graph.hybrid().at(handle)->given(assignment);
      if (component.factor != nullptr) factors.push_back(component.factor);
    }
  }
  return factors;
}

/// -log of some factors, normalisers included.
double objective_of(const HybridGraph& graph, const Values& values, const Assignment& assignment,
                    const std::vector<Handle>& handles) {
  double sum = 0.0;
  for (Handle handle : handles) {
    if (handle.kind == FactorKind::kContinuous) {
      const ContinuousFactor& factor = *graph.continuous().at(handle);
      sum += factor.cost(values) + factor.log_normalizer();
    } else if (handle.kind == FactorKind::kHybrid) {
      sum += graph.hybrid().at(handle)->cost(values, assignment);
    }
  }
  return sum;
}

/// What elimination leaves of a system.
struct Eliminated {
  Eigen::MatrixXd rest;   // H of the separator and the right-hand side
  Eigen::MatrixXd moved;  // the variables that are gone by the separator and the right-hand side
  double log_det = 0.0;   // of the block of the variables that are gone
  int rank = 0;           // rows of that block in the determinant
  std::vector<int> open;  // rows of which nothing is known
};

/// Cholesky elimination with pivoting, so that directions of which nothing is known drop out: they
/// say nothing about the separator either.
Eliminated eliminate(const System& system) {
  const int g = system.gone, n = system.size + 1 - g;
  Eigen::VectorXd scale = system.H.diagonal().head(g);  // of the units of the variables
  for (double& s : scale) s = s > 0.0 ? 1.0 / std::sqrt(s) : 0.0;
  const PivotedCholesky factor(
      scale.asDiagonal() *
          Eigen::MatrixXd(system.H.topLeftCorner(g, g).selfadjointView<Eigen::Lower>()) *
          scale.asDiagonal(),
      kPivotTolerance);
  Eliminated out;
  out.rest = system.H.bottomRightCorner(n, n);
  out.rank = factor.rank();
  const Eigen::MatrixXd Y = factor.triangle().solve(
      factor.pivots_of(scale.asDiagonal() * system.H.bottomLeftCorner(n, g).transpose()));
  rank_update(out.rest, Y.transpose(), -1.0);
  out.moved = Eigen::MatrixXd::Zero(g, n);
  const Eigen::MatrixXd X = factor.triangle().adjoint().solve(Y);
  for (int k = 0; k < out.rank; ++k) {
    out.moved.row(factor.order[k]) = -scale[factor.order[k]] * X.row(k);
    out.log_det += 2.0 * std::log(factor.lower(k, k) / scale[factor.order[k]]);
  }
  out.open.assign(factor.order.data() + out.rank, factor.order.data() + g);
  return out;
}

/// Whether the continuous part of a factor is the same for all its discrete values.
bool same_component(const HybridFactor& factor) {
  Assignment assignment;
  const std::size_t joint = joint_size(factor.discrete_keys());
  int index = 0;
  for (std::size_t i = 0; i < joint; ++i) {
    std::size_t rest = i;
    for (const DiscreteKey& key : factor.discrete_keys()) {
      assignment.set(key.key, static_cast<int>(rest % key.cardinality));
      rest /= key.cardinality;
    }
    const int own = factor.given(assignment).index;
    if (i > 0 && own != index) return false;
    index = own;
  }
  return true;
}

/// What is left of the hybrid factors for the discrete variables: tables, zero at the present
/// assignment; those over the same variables are summed.
std::vector<Table> remaining_tables(const HybridGraph& graph, const Values& values,
                                    const Assignment& assignment,
                                    const std::vector<Handle>& handles,
                                    const std::function<bool(Key)>& stays) {
  std::vector<Table> tables;
  for (Handle handle : handles) {
    if (handle.kind != FactorKind::kHybrid) continue;
    const HybridFactor& factor = *graph.hybrid().at(handle);
    const auto& own = factor.discrete_keys();
    const bool tied =
        std::any_of(own.begin(), own.end(), [&](const DiscreteKey& key) { return stays(key.key); });
    if (!tied && !same_component(factor)) continue;
    for (const Table& table : factor.given(values)) {
      std::vector<double> costs = table.costs();
      const double incumbent = table.cost(assignment);
      for (double& cost : costs) cost -= incumbent;
      const auto same = std::find_if(tables.begin(), tables.end(), [&](const Table& other) {
        return other.keys() == table.keys();
      });
      if (same == tables.end()) {
        tables.emplace_back(table.keys(), std::move(costs));
        continue;
      }
      for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += same->costs()[i];
      *same = Table(table.keys(), std::move(costs));
    }
  }
  return tables;
}

/// Pairs of separator variables without a common factor among `factors`.
int count_fill(const std::vector<Key>& separator,
               const std::vector<const ContinuousFactor*>& factors) {
  std::set<std::pair<Key, Key>> together;
  for (const ContinuousFactor* factor : factors) {
    for (Key a : factor->keys()) {
      for (Key b : factor->keys()) {
        if (a < b) together.emplace(a, b);
      }
    }
  }
  int fill = 0;
  for (std::size_t i = 0; i < separator.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto pair = std::minmax(separator[i], separator[j]);
      fill += together.count({pair.first, pair.second}) == 0;
    }
  }
  return fill;
}

}  // namespace

Marginalization marginalize(const HybridGraph& graph, const Values& values,
                            const Assignment& assignment, const std::vector<Key>& keys,
                            const std::vector<Handle>& factors,
                            const std::function<bool(Key)>& stays) {
  Marginalization result;
  result.delta.remove = factors;
  result.delta.remove_values = keys;
  const auto active = active_factors(graph, assignment, factors);
  System system;
  for (Key key : keys) system.append(key, values.type(key).dim);
  system.gone = system.size;
  for (const ContinuousFactor* factor : active) {
    for (std::size_t i = 0; i < factor->keys().size(); ++i)
      system.append(factor->keys()[i], factor->types()[i].dim);
  }
  result.separator.assign(system.keys.begin() + static_cast<std::ptrdiff_t>(keys.size()),
                          system.keys.end());
  result.fill = count_fill(result.separator, active);
  system.H.setZero(system.size + 1, system.size + 1);
  for (const ContinuousFactor* factor : active) system.add(*factor, values);
  result.finite = system.H.allFinite();
  if (!result.finite) return result;

  const Eliminated left = eliminate(system);
  for (Key key : keys) {
    const int first = system.row.at(key), end = first + values.type(key).dim;
    if (std::any_of(left.open.begin(), left.open.end(),
                    [&](int row) { return first <= row && row < end; }))
      result.undetermined.push_back(key);
  }
  const int s = system.size - system.gone;
  result.follows = left.moved.leftCols(s);
  result.information = system.H.diagonal().head(system.gone);
  // Laplace: -log of the integral over the variables that go, less what the prior says of it.
  double constant = objective_of(graph, values, assignment, factors) +
                    0.5 * (left.log_det - left.rank * std::log(2.0 * M_PI)) +
                    0.5 * (left.rest(s, s) - system.H(system.size, system.size));
  if (left.rest.diagonal().head(s).any()) {
    std::vector<bool> located;
    for (Key key : result.separator) located.push_back(system.located.count(key) != 0);
    const Eigen::MatrixXd information =
        left.rest.topLeftCorner(s, s).selfadjointView<Eigen::Lower>();
    const auto prior = LinearPrior::from_information(result.separator, values, information,
                                                     left.rest.row(s).head(s), std::move(located),
                                                     system.H.diagonal().segment(system.gone, s));
    constant -= prior->cost(values);
    result.delta.continuous.push_back(prior);
  }
  result.delta.discrete = remaining_tables(graph, values, assignment, factors, stays);
  result.delta.discrete.emplace_back(std::vector<DiscreteKey>{}, std::vector<double>{constant});
  return result;
}

}  // namespace hybrid
