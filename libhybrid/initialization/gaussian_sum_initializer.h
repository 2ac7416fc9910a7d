// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "libhybrid/core/option.h"
#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// Before any measurement a landmark may be anywhere within some kilometres: the sigma of its place
/// [m].
inline constexpr double kAnywhere = 1000;

/// When a landmark that no single measurement places is taken into the map.
struct BankOptions {
  double dominance = 0.999;
  double max_sigma = 0.2;  ///< a model that is linear about the place holds no further
  int min_measurements = 5;
  int max_measurements = 200;  ///< further ones replace the oldest
  double outlier_share = 0.02;
  double drift = 0.1;

  template <class Table>
  static void describe(Table& table) {
    using O = BankOptions;
    table.option("dominance", &O::dominance, {0.5, 1.0},
                 "a landmark is placed once its best place has this probability");
    table.option("max_sigma", &O::max_sigma, {1e-6, 10},
                 "and is known in every direction to this share of how far away it is");
    table.option("min_measurements", &O::min_measurements, {1, 1e6},
                 "measurements before a decision");
    table.option("max_measurements", &O::max_measurements, {2, 1e6},
                 "kept of a landmark that has no place yet");
    table.option("outlier_share", &O::outlier_share, {1e-9, 0.5}, "of measurements that are false");
    table.option("drift", &O::drift, kLength,
                 "of the robot while a landmark has no place yet, added to the noise [m]");
  }
};

/// The places where a landmark may be that is seen by range or by bearing only: a mixture of
/// Gaussians whose components start on the ring, or along the ray, of the first measurement, are
/// refined by every further one, fall together where they meet, and weigh as much as the
/// measurements support them (their evidence by Laplace's method). A measurement is right or false:
/// its likelihood is the mixture of its Gaussian and of a constant. Once one place dominates, the
/// landmark is placed.
class GaussianSumInitializer {
 public:
  /// Starts at candidates for the landmark in the map [m], 2 or 3 coordinates.
  explicit GaussianSumInitializer(std::vector<Eigen::VectorXd> candidates);

  /// One measurement in the two forms it is needed in.
  struct Measurement {
    ContinuousFactorPtr trial;   ///< over (pose, point), its noise widened by the drift
    ContinuousFactorPtr real;    ///< over (pose, point), for the graph
    double outlier_density = 0;  ///< of a false measurement, in the unit of its residual
    std::vector<double> class_likelihood = {};  ///< empty if it says nothing of the class
  };

  void add(Measurement measurement, const BankOptions& options);
  /// Whether the best place explains too little: the first measurement may have been false, and
  /// `add_candidates` should give places where another one puts the landmark.
  bool needs_candidates() const;
  void add_candidates(std::vector<Eigen::VectorXd> candidates);

  /// Refines and weighs the places with poses from where `pose` finds them.
  void refine(const std::function<const double*(Key)>& pose, const BankOptions& options);

  /// The place that dominates, if one does.
  std::optional<Eigen::VectorXd> decided(const BankOptions& options) const;
  /// Why none does, for a person; null if one does.
  const char* undecided(const BankOptions& options) const;

  /// All measurements, to be put into the graph once the landmark is placed.
  const std::vector<Measurement>& measurements() const { return measurements_; }

  struct Place {
    Eigen::VectorXd point;
    Eigen::MatrixXd covariance;
    double cost = 0;       ///< -log evidence, up to a constant common to all places
    double explained = 0;  ///< expected number of right measurements
    double distance = 0;   ///< from where it was seen, in the middle [m]
    double probability = 0;
  };
  /// Most probable first, after refine().
  const std::vector<Place>& places() const { return places_; }

 private:
  std::vector<Measurement> measurements_;
  std::vector<Place> places_;
};

/// -log likelihood of some measurements with the landmark at `point`, each right or false.
double measurement_cost(const std::vector<GaussianSumInitializer::Measurement>& measurements,
                        const Eigen::VectorXd& point, const std::function<const double*(Key)>& pose,
                        double outlier_share);

/// Points all around a center at a distance [m], on a circle or on a sphere.
std::vector<Eigen::VectorXd> ring_places(const Eigen::VectorXd& center, double radius, int count);

/// Points along a ray, at depths that grow by equal factors from least to greatest [m].
std::vector<Eigen::VectorXd> ray_places(const Eigen::VectorXd& origin,
                                        const Eigen::VectorXd& direction, double least,
                                        double greatest, int count);

}  // namespace hybrid
