// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/alignment.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "libhybrid/registration/detail/cloud.h"

namespace hybrid {
namespace {

int chunks_of(std::size_t count) {
  return static_cast<int>((count + kPointsPerTask - 1) / kPointsPerTask);
}

/// The sums that make up the normal equations, with p relative to the pivot and r = p - q.
struct Moments {
  double count = 0.0;
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // p x r
  Eigen::Matrix3d pp = Eigen::Matrix3d::Zero();
  Alignment::Matrix6 directed = Alignment::Matrix6::Zero();  // a a' with a = (n, p x n)
  Alignment::Vector6 directed_r = Alignment::Vector6::Zero();

  Moments& operator+=(const Moments& o) {
    count += o.count;
    p += o.p;
    r += o.r;
    torque += o.torque;
    pp += o.pp;
    directed += o.directed;
    directed_r += o.directed_r;
    return *this;
  }
};

struct Squares {
  double along_direction = 0.0;
  double all = 0.0;
  Squares& operator+=(const Squares& o) {
    along_direction += o.along_direction;
    all += o.all;
    return *this;
  }
};

}  // namespace

SE3 moved(const SE3& T_target_source, const Alignment::Vector6& motion,
          const Eigen::Vector3d& pivot) {
  const SO3 turn = SO3::exp(motion.tail<3>());
  SO3 rotation = turn * T_target_source.rotation();
  rotation.normalize();
  return {pivot + turn * (T_target_source.translation() - pivot) + motion.head<3>(), rotation};
}

Alignment::Alignment(Points source, const TargetCloud& target, const MatchNoise& noise,
                     WorkerPool& pool)
    : source_(std::move(source)),
      target_(&target),
      noise_(noise),
      pool_(&pool),
      assignment_(source_.size(), -1) {
  const CloudSpread spread = spread_of(source_);
  center_ = spread.center;
  radius_ = spread.radius();
}

void Alignment::set_noise(const MatchNoise& noise) {
  noise_ = noise;
}

double Alignment::match(const SE3& T_target_source) {
  const Eigen::Matrix3d R = T_target_source.rotation().matrix();
  const Eigen::Vector3d& t = T_target_source.translation();
  const MatchWeights weights(noise_, target_->shape());
  struct Tally {
    double distance = 0.0;
    int changes = 0, inliers = 0;
  };
  std::vector<Tally> tallies(chunks_of(size()));
  pool_->run(static_cast<int>(tallies.size()), [&](int chunk) {
    Tally tally;
    const std::size_t end = std::min(size(), std::size_t(chunk + 1) * kPointsPerTask);
    for (std::size_t i = std::size_t(chunk) * kPointsPerTask; i < end; ++i) {
      double distance = 0.0;
      const int matched =
          target_->match(R * source_[i] + t, noise_, weights, assignment_[i], distance);
      tally.distance += distance;
      tally.changes += matched != assignment_[i];
      tally.inliers += matched >= 0;
      assignment_[i] = matched;
    }
    tallies[chunk] = tally;
  });
  Tally all;
  for (const Tally& tally : tallies) {
    all.distance += tally.distance;
    all.changes += tally.changes;
    all.inliers += tally.inliers;
  }
  changes_ = all.changes;
  inliers_ = all.inliers;
  return 0.5 * all.distance;
}

template <class Sum, class Visit>
Sum Alignment::sum_over_pairs(const SE3& T_target_source, const Visit& visit) const {
  const Eigen::Matrix3d R = T_target_source.rotation().matrix();
  const Eigen::Vector3d& t = T_target_source.translation();
  std::vector<Sum> sums(chunks_of(size()));
  pool_->run(static_cast<int>(sums.size()), [&](int chunk) {
    Sum sum{};
    const std::size_t end = std::min(size(), std::size_t(chunk + 1) * kPointsPerTask);
    for (std::size_t i = std::size_t(chunk) * kPointsPerTask; i < end; ++i) {
      const int k = assignment_[i];
      if (k < 0) continue;
      const Eigen::Vector3d p = R * source_[i] + t;
      visit(sum, p, p - target_->point(k), target_->direction(k));
    }
    sums[chunk] = sum;
  });
  Sum all{};
  for (const Sum& sum : sums) all += sum;
  return all;
}

double Alignment::objective(const SE3& T_target_source) const {
  const MatchWeights weights(noise_, target_->shape());
  const double pairs = sum_over_pairs<double>(
      T_target_source, [&](double& sum, const Eigen::Vector3d&, const Eigen::Vector3d& r,
                           const Eigen::Vector3d& direction) { sum += weights(r, direction); });
  const double outliers = static_cast<double>(size()) - inliers_;
  return 0.5 * (pairs + outliers * noise_.gate * noise_.gate);
}

Alignment::System Alignment::system(const SE3& T_target_source, const MatchWeights& weights,
                                    const Eigen::Vector3d& pivot) const {
  const auto m = sum_over_pairs<Moments>(
      T_target_source, [&](Moments& sum, const Eigen::Vector3d& at, const Eigen::Vector3d& r,
                           const Eigen::Vector3d& direction) {
        const Eigen::Vector3d p = at - pivot;
        sum.count += 1.0;
        sum.p += p;
        sum.r += r;
        sum.torque += p.cross(r);
        sum.pp.noalias() += p * p.transpose();
        Vector6 a;
        a << direction, p.cross(direction);
        sum.directed.noalias() += a * a.transpose();
        sum.directed_r += a * direction.dot(r);
      });
  System system;
  system.H.topLeftCorner<3, 3>() = m.count * Eigen::Matrix3d::Identity();
  system.H.topRightCorner<3, 3>() = -hat(m.p);
  system.H.bottomLeftCorner<3, 3>() = hat(m.p);
  system.H.bottomRightCorner<3, 3>() = m.pp.trace() * Eigen::Matrix3d::Identity() - m.pp;
  system.H = weights.all * system.H + weights.directed * m.directed;
  system.g << weights.all * m.r, weights.all * m.torque;
  system.g += weights.directed * m.directed_r;
  return system;
}

double Alignment::align(SE3& T_target_source, int max_steps) {
  constexpr double kFirstDamping = 1e-6, kMaxDamping = 1e3;
  constexpr double kSmallDecrease = 1e-6;
  const MatchWeights weights(noise_, target_->shape());
  double cost = objective(T_target_source);
  double damping = 0.0;
  for (int step = 0; step < max_steps && inliers_ > 0; ++step) {
    const Eigen::Vector3d pivot = T_target_source * center_;
    const System s = system(T_target_source, weights, pivot);
    bool lowered = false;
    double decrease = 0.0;
    while (!lowered && damping < kMaxDamping) {
      Matrix6 H = s.H;
      H.diagonal() *= 1.0 + damping;
      // The least-norm solution has no motion in directions that the pairs leave free.
      const Vector6 motion = -H.completeOrthogonalDecomposition().solve(s.g);
      const SE3 candidate = moved(T_target_source, motion, pivot);
      const double reached = objective(candidate);
      if (reached < cost) {
        decrease = cost - reached;
        T_target_source = candidate;
        cost = reached;
        lowered = true;
        damping *= 0.1;
      } else {
        damping = std::max(10.0 * damping, kFirstDamping);
        if (-s.g.dot(motion) < 1e-12 * cost) return cost;  // at the minimum, up to rounding
      }
    }
    if (!lowered || decrease < kSmallDecrease * cost) break;
  }
  return cost;
}

Alignment::Residuals Alignment::residuals(const SE3& T_target_source) const {
  const auto sum = sum_over_pairs<Squares>(
      T_target_source, [](Squares& s, const Eigen::Vector3d&, const Eigen::Vector3d& r,
                          const Eigen::Vector3d& direction) {
        s.all += r.squaredNorm();
        s.along_direction += direction.dot(r) * direction.dot(r);
      });
  const double n = std::max(1, inliers_);
  Residuals result;
  result.all = std::sqrt(sum.all / n);
  if (target_->shape() == LocalShape::kSurface) result.across = std::sqrt(sum.along_direction / n);
  if (target_->shape() == LocalShape::kCurve) {
    result.across = std::sqrt((sum.all - sum.along_direction) / n);
  }
  if (target_->shape() == LocalShape::kPoint) result.across = std::sqrt(sum.all / (3.0 * n));
  return result;
}

double Alignment::noise_across(const SE3& T_target_source) const {
  const Eigen::Matrix3d R = T_target_source.rotation().matrix();
  const Eigen::Vector3d& t = T_target_source.translation();
  std::vector<double> squares;
  squares.reserve(inliers_);
  for (std::size_t i = 0; i < size(); ++i) {
    const int k = assignment_[i];
    if (k < 0) continue;
    const Eigen::Vector3d r = R * source_[i] + t - target_->point(k);
    const double d = target_->direction(k).dot(r);
    squares.push_back(target_->shape() == LocalShape::kSurface ? d * d : r.squaredNorm() - d * d);
  }
  if (squares.empty()) return 0.0;
  // The median of a squared normal variable in 1 and 3 dimensions (chi-square distribution); curves
  // are in a plane, so that the distance across them has 1.
  return std::sqrt(median(std::move(squares)) /
                   (target_->shape() == LocalShape::kPoint ? 2.3660 : 0.4549));
}

double Alignment::motion(const SE3& from, const SE3& to) const {
  return (to * center_ - from * center_).norm() +
         radius_ * (from.rotation().inverse() * to.rotation()).log().norm();
}

}  // namespace hybrid
