// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/discrete/junction_forest.h"
#include "libhybrid/discrete/table.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Limits of exact inference, and the behaviour beyond them.
struct DiscreteOptions : TableLimits {
  /// Whether a component over the limits is improved by local search from the current assignment
  /// (never worse than it); if not, it is an Error that names the table.
  bool local_search_when_too_large = true;
  int max_sweeps = 50;  ///< of local search over all variables of a component
};

/// The outcome of a discrete solve.
struct DiscreteReport {
  double cost = 0.0;            ///< sum of all tables; +infinity if nothing possible was found
  bool exact = true;            ///< false if local search replaced elimination
  std::vector<Key> changed;     ///< variables that are new or have another value than before
  std::vector<Key> impossible;  ///< variables of tables that together allow no joint value
};

struct DiscreteSolution : DiscreteReport {
  Assignment assignment;  ///< of every variable of the tables
};

/// The joint values of least total cost (eq. 9a), by variable elimination within each connected
/// component: on a chain this is the Viterbi algorithm, on a single variable a minimum. Ties keep
/// the incumbent value, so that a component changes only if its cost decreases; an impossible
/// component keeps its incumbent. Tables of components that need no solution can be left out.
/// Throws Error if tables disagree about a cardinality, or over the limits without local search.
DiscreteSolution solve_discrete(const std::vector<const Table*>& tables,
                                const DiscreteOptions& options = {},
                                const Assignment* incumbent = nullptr);

/// The same in place: `assignment` is the incumbent, and receives the values that changed.
DiscreteReport update_assignment(const std::vector<const Table*>& tables,
                                 const DiscreteOptions& options, Assignment& assignment);

/// Exact marginals of all variables of some tables (eq. 11a).
class DiscreteMarginals {
 public:
  /// Probability of each value; throws Error for a variable in none of the tables.
  Eigen::Map<const Eigen::VectorXd> at(Key key) const;
  bool contains(Key key) const { return places_.count(key) != 0; }
  std::size_t size() const { return places_.size(); }
  /// log of the sum of exp(-cost) over all joint values.
  double log_partition() const { return log_partition_; }

 private:
  friend DiscreteMarginals discrete_marginals(const std::vector<const Table*>& tables,
                                              const TableLimits& limits);
  struct Place {
    std::size_t begin = 0;
    int size = 0;
  };

  std::unordered_map<Key, Place> places_;
  std::vector<double> probabilities_;
  double log_partition_ = 0.0;
};

/// Sum-product on junction trees, one pass up and one down. Throws Error if no joint value is
/// possible, and over the limits.
DiscreteMarginals discrete_marginals(const std::vector<const Table*>& tables,
                                     const TableLimits& limits = {});

/// Joint probabilities of chosen variables, row-major in the order given. Throws as above, and for
/// a variable in none of the tables.
std::vector<double> joint_marginal(const std::vector<const Table*>& tables,
                                   const std::vector<Key>& variables,
                                   const TableLimits& limits = {});

/// Joint probabilities of the variables of every table, row-major like its costs: the expected
/// sufficient statistics of expectation-maximisation.
struct TableMarginals {
  std::vector<std::vector<double>> tables;  ///< one per table; {1} for one without variables
  double log_partition = 0.0;               ///< log of the sum of exp(-cost) over all joint values
};

/// The marginals of all tables by one sum-product, two passes over the junction tree. Throws as
/// above.
TableMarginals table_marginals(const std::vector<const Table*>& tables,
                               const TableLimits& limits = {});

}  // namespace hybrid
