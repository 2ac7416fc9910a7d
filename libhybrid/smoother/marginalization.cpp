// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/marginalization.h"

#include <Eigen/Core>
#include <algorithm>
#include <set>
#include <unordered_map>
#include <utility>

#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/linear/front.h"

namespace hybrid {
namespace {

constexpr double kPivotTolerance = 1e-13;

/// Rows of the variables in the dense system: those to go first, then the separator.
struct Layout {
  std::vector<Key> keys;
  std::unordered_map<Key, int> row;
  int gone = 0;  // rows of the variables to go
  int size = 0;

  void append(Key key, int dim) {
    if (!row.emplace(key, size).second) return;
    keys.push_back(key);
    size += dim;
  }
};

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

void add_to(Front& front, const Layout& layout, const ContinuousFactor& factor,
            const Values& values) {
  const auto x = gather(factor.keys(), factor.types(), values);
  Eigen::MatrixXd A(factor.rows(), factor.cols() + 1);
  factor.linearize(x.data(), A.rightCols(1).data(), A.data());
  const Eigen::MatrixXd H = A.transpose() * A;
  std::vector<int> place;
  for (std::size_t i = 0; i < factor.keys().size(); ++i) {
    for (int k = 0; k < factor.types()[i].dim; ++k) {
      place.push_back(layout.row.at(factor.keys()[i]) + k);
    }
  }
  place.push_back(layout.size);
  for (std::size_t j = 0; j < place.size(); ++j) {
    for (std::size_t i = j; i < place.size(); ++i) {
      front(std::max(place[i], place[j]), std::min(place[i], place[j])) += H(i, j);
    }
  }
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
  Layout layout;
  for (Key key : keys) layout.append(key, values.type(key).dim);
  layout.gone = layout.size;
  for (const ContinuousFactor* factor : active) {
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      layout.append(factor->keys()[i], factor->types()[i].dim);
    }
  }
  result.separator.assign(layout.keys.begin() + static_cast<std::ptrdiff_t>(keys.size()),
                          layout.keys.end());
  result.fill = count_fill(result.separator, active);

  Front front;
  front.reset(layout.size + 1);
  for (const ContinuousFactor* factor : active) add_to(front, layout, *factor, values);
  const int failed = front.factorize(layout.gone, kPivotTolerance);
  if (failed >= 0) {
    result.determined = false;
    for (Key key : keys) {
      if (layout.row.at(key) <= failed) result.under_constrained = key;
    }
    return result;
  }
  const int s = layout.size - layout.gone;
  if (s > 0) {
    Eigen::MatrixXd information(s, s);
    Eigen::VectorXd gradient(s);
    for (int j = 0; j < s; ++j) {
      for (int i = j; i < s; ++i) {
        information(i, j) = information(j, i) = front(layout.gone + i, layout.gone + j);
      }
      gradient[j] = front(layout.size, layout.gone + j);
    }
    if (information.diagonal().maxCoeff() > 0.0) {
      result.delta.continuous.push_back(
          LinearPrior::from_information(result.separator, values, information, gradient));
    }
  }
  result.delta.discrete = remaining_tables(graph, values, assignment, factors, stays);
  return result;
}

}  // namespace hybrid
