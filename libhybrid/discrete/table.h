// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
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

/// A table conditioned on the values that an assignment gives to some of its variables. Throws
/// Error for a value that is out of range.
Table condition(const Table& table, const Assignment& held);

/// -log p for each value; probabilities must be non-negative and finite with a positive sum, and
/// are normalised.
Table prior_table(DiscreteKey key, const std::vector<double>& probabilities);

/// -log p(to | from): row-major, one row per value of `from`, each summing to one within 1e-6.
Table transition_table(DiscreteKey from, DiscreteKey to, const std::vector<double>& probabilities);

}  // namespace hybrid
