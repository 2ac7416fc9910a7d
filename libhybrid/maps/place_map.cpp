// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/place_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

constexpr double kMoreReach = 1.5;  // than was asked for, so that the next question has it, too

/// Density of the landmarks where there are some, per m^2 or m^3: the median over them of that
/// within the distance of the fifth nearest.
template <class Point>
double local_density(const std::vector<Point>& points) {
  constexpr int kDim = Point::RowsAtCompileTime;
  const std::size_t k = std::min<std::size_t>(5, points.size() - 1);
  const double unit = kDim == 2 ? M_PI : 4 * M_PI / 3;  // of a disc or a ball
  std::vector<double> densities;
  for (const Point& p : points) {
    std::vector<double> d;
    for (const Point& q : points) d.push_back((p - q).norm());
    std::nth_element(d.begin(), d.begin() + static_cast<std::ptrdiff_t>(k), d.end());
    densities.push_back(static_cast<double>(k) / (unit * std::pow(std::max(d[k], 1e-3), kDim)));
  }
  return median(std::move(densities));
}

}  // namespace

template <class Pose>
PlaceMap<Pose>::PlaceMap(const MapRecord& map, std::vector<int> landmarks)
    : prior_(map.prior), landmarks_(std::move(landmarks)), neighbours_(landmarks_.size()) {
  const std::vector<Eigen::MatrixXd> all = prior_.covariances();
  for (const int i : landmarks_) {
    points_.push_back(map.landmarks[static_cast<std::size_t>(i)].position.template head<kDim>());
    alone_.push_back(all[static_cast<std::size_t>(i)]);
  }
  if (!points_.empty()) density_ = local_density(points_);
}

template <class Pose>
double PlaceMap<Pose>::log_volume_of_poses() const {
  const double spacing = std::exp(-std::log(density_) / kDim);
  const auto box = box_of(points_, [](const Point& p) { return p; });
  const double headings = kDim == 2 ? 2 * M_PI : 8 * M_PI * M_PI;
  return (box.sizes().array() + spacing).log().sum() + std::log(headings);
}

/// Covariances of all landmarks of the prior with one: R' z = E, then R x = z.
template <class Pose>
Eigen::MatrixXd PlaceMap<Pose>::columns_of(int anchor) const {
  const int own = landmarks_[static_cast<std::size_t>(anchor)];
  const auto n = static_cast<Eigen::Index>(prior_.rows.size());
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(kDim * n, kDim);
  x.template middleRows<kDim>(kDim * own).setIdentity();
  const auto block = [](const SparseRow& row, std::size_t k) {
    return row.R.template middleCols<kDim>(kDim * static_cast<Eigen::Index>(k));
  };
  for (int i = own; i >= 0; --i) {
    const SparseRow& row = prior_.rows[static_cast<std::size_t>(i)];
    auto xi = x.template middleRows<kDim>(kDim * i);
    if (xi.isZero(0)) continue;
    xi = Matrix(Matrix(block(row, 0)).transpose().inverse() * xi);
    for (std::size_t k = 1; k < row.variables.size(); ++k) {
      x.template middleRows<kDim>(kDim * row.variables[k]) -= block(row, k).transpose() * xi;
    }
  }
  for (int i = 0; i < n; ++i) {
    const SparseRow& row = prior_.rows[static_cast<std::size_t>(i)];
    Matrix sum = x.template middleRows<kDim>(kDim * i);
    for (std::size_t k = 1; k < row.variables.size(); ++k) {
      sum -= block(row, k) * x.template middleRows<kDim>(kDim * row.variables[k]);
    }
    x.template middleRows<kDim>(kDim * i) = Matrix(block(row, 0)).inverse() * sum;
  }
  return x;
}

template <class Pose>
std::vector<typename PlaceMap<Pose>::Matrix> PlaceMap<Pose>::relative_covariances(
    int anchor, const std::vector<int>& of) const {
  const Eigen::MatrixXd columns = columns_of(anchor);
  std::vector<Matrix> out;
  for (const int i : of) {
    const Matrix with = columns.template middleRows<kDim>(
        kDim * static_cast<Eigen::Index>(landmarks_[static_cast<std::size_t>(i)]));
    out.push_back(i == anchor
                      ? Matrix(Matrix::Zero())
                      : Matrix(alone_[static_cast<std::size_t>(i)] +
                               alone_[static_cast<std::size_t>(anchor)] - with - with.transpose()));
  }
  return out;
}

template <class Pose>
const std::vector<typename PlaceMap<Pose>::Neighbour>& PlaceMap<Pose>::neighbours(
    int anchor, double reach) const {
  if (reach > reach_) {
    reach_ = kMoreReach * reach;
    for (auto& list : neighbours_) list.clear();
  }
  std::vector<Neighbour>& out = neighbours_[static_cast<std::size_t>(anchor)];
  if (!out.empty()) return out;
  std::vector<int> near;
  for (int j = 0; j < static_cast<int>(points_.size()); ++j) {
    const double d =
        (points_[static_cast<std::size_t>(anchor)] - points_[static_cast<std::size_t>(j)]).norm();
    if (d >= reach_) continue;
    near.push_back(j);
    out.push_back({d, j, 0});
  }
  const std::vector<Matrix> relative = relative_covariances(anchor, near);
  for (std::size_t k = 0; k < near.size(); ++k) out[k].variance = relative[k].trace() / kDim;
  std::sort(out.begin(), out.end());
  return out;  // holds at least the landmark itself
}

template class PlaceMap<SE2>;
template class PlaceMap<SE3>;

}  // namespace hybrid
