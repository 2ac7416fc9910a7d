// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/key.h"

namespace HYBRID_API hybrid {

/// A discrete factor f_k(D_k) of eq. 2 as a table of costs -log f, dense over the joint values of
/// its variables, the first variable varying slowest. An entry may be +infinity (impossible), never
/// NaN or -infinity.
class Table {
 public:
  Table() = default;
  /// Throws Error unless there is one cost per joint value, all in range, and no variable named
  /// twice.
  Table(std::vector<DiscreteKey> keys, std::vector<double> costs);

  const std::vector<DiscreteKey>& keys() const { return keys_; }
  const std::vector<double>& costs() const { return costs_; }

  /// Index in `costs()` of the joint value that an assignment gives to the variables of the table.
  std::size_t index(const Assignment& assignment) const;
  double cost(const Assignment& assignment) const { return costs_[index(assignment)]; }

 private:
  std::vector<DiscreteKey> keys_;
  std::vector<double> costs_;
};

/// Number of joint values of some variables; throws Error if it does not fit a size_t.
std::size_t joint_size(const std::vector<DiscreteKey>& keys);

/// The row-major index of the values that an assignment gives to `keys`.
std::size_t joint_index(const std::vector<DiscreteKey>& keys, const Assignment& assignment);

/// Gives `keys` the values of that row-major index.
void set_joint(const std::vector<DiscreteKey>& keys, std::size_t index, Assignment& assignment);

/// The names of some variables, with commas between.
std::string names_of(const std::vector<DiscreteKey>& keys);

/// A table conditioned on the values that an assignment gives to some of its variables. Throws
/// Error for a value that is out of range.
Table condition(const Table& table, const Assignment& held);

/// -log f of a potential, which need not be normalised: +infinity (impossible) for zero. Throws
/// Error unless it is finite and not negative.
double to_cost(double potential);

/// exp(-cost): zero for +infinity.
double to_potential(double cost);

/// A factor from its potentials f >= 0, one per joint value of its variables, the first variable
/// varying slowest. Throws Error for one that is negative or not finite, or another number of them.
Table potential_table(std::vector<DiscreteKey> keys, const std::vector<double>& potentials);

/// p(child | parents), row-major: a row of the child's values for every joint value of the parents,
/// the first parent varying slowest. Throws Error naming the row that does not sum to one within
/// 1e-6, or that has an entry which is not a probability. The variables of the table are the
/// parents, then the child.
Table conditional_table(DiscreteKey child, const std::vector<DiscreteKey>& parents,
                        const std::vector<double>& probabilities);

/// -log p for each value; probabilities must be non-negative and finite with a positive sum, and
/// are normalised.
Table prior_table(DiscreteKey key, const std::vector<double>& probabilities);

/// -log p(to | from): row-major, one row per value of `from`, each summing to one within 1e-6.
Table transition_table(DiscreteKey from, DiscreteKey to, const std::vector<double>& probabilities);

}  // namespace hybrid
