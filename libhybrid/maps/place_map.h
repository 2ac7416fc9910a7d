// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/association/constellation.h"
#include "libhybrid/maps/map_record.h"

namespace HYBRID_API hybrid {

/// The landmarks of a map that places are looked for among, and what is known of them relative to
/// each other, found as it is asked for. Not to be asked by two threads at once.
template <class Pose>
class HYBRID_API PlaceMap {
 public:
  using Point = typename Pose::Point;
  using Matrix = typename Constellation<Pose>::Matrix;
  static constexpr int kDim = Point::RowsAtCompileTime;

  /// Some landmarks of a stored map, by their places in it.
  PlaceMap(const MapRecord& map, std::vector<int> landmarks);

  const std::vector<Point>& points() const { return points_; }
  /// Per m^2 or m^3, where there are landmarks: the median over them of that within the distance of
  /// the fifth nearest.
  double density() const { return density_; }
  /// log of the volume of the poses that lie in the map: places, and all headings.
  double log_volume_of_poses() const;

  /// Covariance of landmarks relative to another, the axes being those of the map [m^2]; time is
  /// that of two sparse triangular solves.
  std::vector<Matrix> relative_covariances(int anchor, const std::vector<int>& of) const;

  /// A landmark near another one.
  struct Neighbour {
    double distance = 0;
    int landmark = 0;
    double variance = 0;  ///< along an axis, of one relative to the other [m^2]
    bool operator<(const Neighbour& b) const {
      return std::make_pair(distance, landmark) < std::make_pair(b.distance, b.landmark);
    }
  };
  /// Those nearer than `reach` and perhaps some more, the nearest first.
  const std::vector<Neighbour>& neighbours(int anchor, double reach) const;

  /// Covariances of all landmarks of the stored map with one of these [m^2].
  Eigen::MatrixXd columns_of(int anchor) const;

 private:
  SparseGaussian prior_;
  std::vector<int> landmarks_;
  std::vector<Point> points_;
  std::vector<Matrix> alone_;
  double density_ = 0;
  mutable double reach_ = 0;
  mutable std::vector<std::vector<Neighbour>> neighbours_;
};

/// Where in a map some landmarks are, of which no pose is known. The points of `here` have their
/// frame in common.
template <class Pose>
struct PlaceQuestion {
  using Point = typename Pose::Point;
  Constellation<Pose> here;
  std::shared_ptr<const PlaceMap<Pose>> map;
  /// Whether a point of the map was looked at, so that a landmark there would be in it.
  std::function<bool(const Point&)> covers;
  /// log evidence that a landmark of `here` (row) and one of the map (column) are one by all but
  /// where they are; -infinity where they cannot be.
  Eigen::MatrixXd class_log_likelihood_ratio;
  /// The same for two landmarks of the map.
  std::function<double(int, int)> class_log_likelihood_ratio_in_map;
};

}  // namespace hybrid
