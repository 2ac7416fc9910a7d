// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/core/values.h"
#include "libhybrid/core/variable.h"

namespace HYBRID_API hybrid {

/// A measured motion of the second pose seen from the first one, and its information over the
/// tangent.
template <class Pose>
struct RelativePose {
  Pose measured;
  Eigen::Matrix<double, Pose::kDim, Pose::kDim> information;
};

/// A factor over continuous variables, f_k(C_k) of eq. 2: -log f = cost + log_normalizer, with the
/// cost half the squared norm of a whitened residual (under a robust loss if it has one).
/// Immutable.
///
/// Write your own by deriving from FactorOf (factors/factor_of.h); this interface is what solvers
/// see.
class ContinuousFactor {
 public:
  virtual ~ContinuousFactor() = default;

  /// The variables, in the order in which `x` is given to the methods below.
  const std::vector<Key>& keys() const { return keys_; }
  const std::vector<VariableType>& types() const { return types_; }
  /// Length of the residual.
  int rows() const { return rows_; }
  /// Sum of the tangent dimensions of the variables.
  int cols() const { return cols_; }

  /// Cost at x: x[i] points to the storage of variable i.
  virtual double cost(const double* const* x) const = 0;

  /// Linearises at x: whitened residual r (rows) and Jacobian J (rows x cols, column-major), both
  /// scaled by the root of the robust weight, so that J'J and J'r enter the normal equations.
  /// Returns the cost.
  virtual double linearize(const double* const* x, double* r, double* J) const = 0;

  /// -log of the Gaussian density at a zero residual.
  virtual double log_normalizer() const = 0;

  /// Name for messages, e.g. "between".
  virtual std::string name() const = 0;

  /// The motion from keys()[0] to keys()[1] that the factor measures, used by methods on relative
  /// poses: chordal initialisation, consistency of closures, export to pose graphs. Empty if the
  /// factor measures something else.
  virtual std::optional<RelativePose<SE2>> relative_pose_2d() const { return std::nullopt; }
  virtual std::optional<RelativePose<SE3>> relative_pose_3d() const { return std::nullopt; }

  /// Cost at the given values; throws Error if a variable is missing or of another type.
  double cost(const Values& values) const;

 protected:
  ContinuousFactor(std::vector<Key> keys, std::vector<VariableType> types, int rows);

 private:
  std::vector<Key> keys_;
  std::vector<VariableType> types_;
  int rows_;
  int cols_;
};

/// "between factor on x3 x8", for messages.
std::string describe(const std::string& name, const std::vector<Key>& keys);

using ContinuousFactorPtr = std::shared_ptr<const ContinuousFactor>;

/// Pointers to the storage of `keys` in `values`, the `x` of factors. Throws Error if a variable is
/// missing or not of its type in `types`.
std::vector<const double*> gather(const std::vector<Key>& keys,
                                  const std::vector<VariableType>& types, const Values& values);

}  // namespace hybrid
