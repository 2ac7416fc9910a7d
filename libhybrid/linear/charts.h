// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A rigid motion of the map: whether there is one, and then a pose as it is stored.
using MapMotion = std::array<double, 8>;

/// Points about which something was linearised, those of its variables one after the other, and a
/// motion of the map that has carried them along since; null for none.
struct Chart {
  const double* motion = nullptr;
  const double* points = nullptr;

  bool is_moved() const { return motion != nullptr && motion[0] != 0.0; }
};

/// How steps in a chart depend on tangents at the estimates. They are taken from the one to the
/// other as a rigid motion of all variables would take them, and not by their derivatives: what
/// factors leave free at the points of a chart, a motion of the map, they then leave free at the
/// estimates too, however the one differs from the other. A pose knows how it turns; a point turns
/// with a pose, the anchor.
struct Turn {
  std::vector<double> own;        ///< of each variable by its own tangent, dim x dim
  int anchor = -1;                ///< number of the anchor; -1: none
  std::vector<double> by_anchor;  ///< of each variable by the tangent of the anchor
};

/// How the factors and cliques of a Bayes tree see variables that live on manifolds. A factor has
/// the points about which it was linearised, a clique the estimates of when it was made. Where
/// factors hold variables relative to each other alone, a motion of the map leaves their residuals,
/// Jacobians and steps as they are: a subtree of such factors moves with the map above it for the
/// price of moving its estimates.
class Charts {
 public:
  virtual ~Charts() = default;

  /// How many numbers the points of some variables are.
  virtual std::size_t size(const std::vector<int>& variables) const = 0;

  /// Sets points to the present estimates.
  virtual void start(const std::vector<int>& variables, double* points) const = 0;

  /// The steps of the variables from number `first` on that lead from their points to the
  /// estimates, one after the other.
  virtual void see(const std::vector<int>& variables, int first, Chart chart,
                   double* steps) const = 0;
  /// The same, and how they turn. The anchor is the first pose of number `anchor_from` or later, or
  /// if there is none, the first of all.
  virtual void see(const std::vector<int>& variables, int first, int anchor_from, Chart chart,
                   double* steps, Turn& turn) const = 0;

  /// Whether a factor holds the variable in the map, so that it must not be moved with others.
  virtual bool is_held(int variable) const = 0;

  /// The motion of the map after which the variables from number `first` on are seen at the given
  /// steps: exactly the pose of the most weight, or where no pose has any, points in the least
  /// squares sense. Returns false where there are too few points.
  virtual bool find_motion(const std::vector<int>& variables, int first, Chart chart,
                           const double* steps, const double* weights, MapMotion& motion) const = 0;

  /// Adds a motion to an earlier one.
  virtual void add(const MapMotion& motion, double* to) const = 0;

  /// Moves the estimates of the first `count` variables.
  virtual void move(const std::vector<int>& variables, int count, const MapMotion& motion) = 0;

  /// Sets the estimates of the first variables from their steps.
  virtual void place(const std::vector<int>& variables, int count, Chart chart,
                     const double* steps) = 0;
};

}  // namespace hybrid
