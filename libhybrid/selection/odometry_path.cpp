// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/odometry_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>

namespace hybrid {
namespace {

template <class Pose>
using Square = typename Pose::Jacobian;

template <class Pose>
Square<Pose> carry(const Pose& T, const Square<Pose>& covariance) {
  const Square<Pose> Ad = T.adjoint();
  return Ad * covariance * Ad.transpose();
}

/// A pose with the covariance of its tangent.
template <class Pose>
struct Uncertain {
  Pose pose;
  Square<Pose> covariance = Square<Pose>::Zero();
};

/// The pose of the second variable that a factor measures, given the first: Newton's method from
/// the pose in `b`, one or two steps for relative poses. False if the factor does not determine the
/// pose.
template <class Pose>
bool measured_end(const ContinuousFactor& factor, const Pose& a, Uncertain<Pose>& b) {
  constexpr int kSteps = 10;
  constexpr int d = Pose::kDim;
  if (factor.keys().size() != 2 || factor.rows() != d || factor.cols() != 2 * d) return false;
  double xa[Pose::kSize], xb[Pose::kSize];
  a.store(xa);
  const double* x[] = {xa, xb};
  Eigen::Matrix<double, d, 1> r;
  Eigen::Matrix<double, d, 2 * d> J;
  for (int k = 0; k < kSteps; ++k) {
    b.pose.store(xb);
    factor.linearize(x, r.data(), J.data());
    const Square<Pose> Jb = J.template rightCols<d>();
    const Eigen::LLT<Square<Pose>> llt(Jb.transpose() * Jb);
    if (llt.info() != Eigen::Success) return false;
    const typename Pose::Tangent step = -llt.solve(Jb.transpose() * r);
    if (!step.allFinite()) return false;
    b.pose = b.pose * Pose::exp(step);
    b.pose.normalize();
    b.covariance = llt.solve(Square<Pose>::Identity());
    if (step.norm() < 1e-9) return true;
  }
  return r.norm() < 1e-3;
}

template <class Pose, class Path>
Uncertain<Pose> motion(const Path& path, int from, int to) {
  Uncertain<Pose> result{path.poses[from].between(path.poses[to])};
  const Square<Pose> spread =
      from < to ? path.spread[to] - path.spread[from] : path.spread[from] - path.spread[to];
  result.covariance = carry<Pose>(path.poses[to].inverse(), spread);
  return result;
}

/// Prediction of a factor between a known pose and one at an uncertain motion from it.
template <class Pose>
Prediction innovation_at(const ContinuousFactor& factor, const Pose& a,
                         const Uncertain<Pose>& motion) {
  constexpr int d = Pose::kDim;
  double xa[Pose::kSize], xb[Pose::kSize];
  a.store(xa);
  (a * motion.pose).store(xb);
  const double* x[] = {xa, xb};
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(2 * d, 2 * d);
  P.bottomRightCorner(d, d) = motion.covariance;
  return predict_measurement(factor, x, P);
}

template <class Pose>
bool is_between(const ContinuousFactor& factor) {
  const VariableType type = Variable<Pose>::type();
  return factor.types().size() == 2 && factor.types()[0] == type && factor.types()[1] == type;
}

}  // namespace

void OdometryPath::start(Key pose, VariableType type, const double* x) {
  const auto begin = [&](auto& path, const auto& value) {
    index_.emplace(pose, static_cast<int>(path.poses.size()));
    path.poses.push_back(value);
    path.spread.emplace_back();
    path.spread.back().setZero();
    path.part.push_back(parts_++);
  };
  const bool planar = type == Variable<SE2>::type();
  if (!planar && type != Variable<SE3>::type()) return;
  if (path_.index() == 0) {
    if (planar) {
      path_.emplace<Path<SE2>>();
    } else {
      path_.emplace<Path<SE3>>();
    }
  }
  if (auto* path2 = std::get_if<Path<SE2>>(&path_); path2 != nullptr && planar) {
    begin(*path2, SE2::load(x));
  } else if (auto* path3 = std::get_if<Path<SE3>>(&path_); path3 != nullptr && !planar) {
    begin(*path3, SE3::load(x));
  }
}

template <class Pose>
void OdometryPath::append_pose(Path<Pose>& path, Key from, Key to, const ContinuousFactor& step,
                               const Pose& start) {
  const int last = index(from);
  const bool forward = step.keys()[0] == from;
  Uncertain<Pose> end{start};
  const bool newest = last >= 0 && last + 1 == static_cast<int>(path.poses.size());
  if (!newest || !forward || !is_between<Pose>(step) ||
      !measured_end(step, path.poses[last], end)) {
    double x[Pose::kSize];
    start.store(x);
    this->start(to, Variable<Pose>::type(), x);
    return;
  }
  index_.emplace(to, last + 1);
  path.spread.push_back(path.spread[last] + carry<Pose>(end.pose, end.covariance));
  path.poses.push_back(end.pose);
  path.part.push_back(path.part[last]);
}

void OdometryPath::append(Key from, Key to, const ContinuousFactor& step, VariableType type,
                          const double* x) {
  if (auto* path2 = std::get_if<Path<SE2>>(&path_);
      path2 != nullptr && type == Variable<SE2>::type()) {
    append_pose(*path2, from, to, step, SE2::load(x));
  } else if (auto* path3 = std::get_if<Path<SE3>>(&path_);
             path3 != nullptr && type == Variable<SE3>::type()) {
    append_pose(*path3, from, to, step, SE3::load(x));
  }
}

void OdometryPath::shrink(std::size_t size) noexcept {
  for (auto it = index_.begin(); it != index_.end();) {
    it = static_cast<std::size_t>(it->second) < size ? std::next(it) : index_.erase(it);
  }
  std::visit(
      [&](auto& path) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(path)>, std::monostate>) {
          path.poses.resize(std::min(size, path.poses.size()));
          path.spread.resize(std::min(size, path.spread.size()));
          path.part.resize(std::min(size, path.part.size()));
          parts_ = path.part.empty() ? 0 : path.part.back() + 1;
        }
      },
      path_);
  if (size == 0) path_ = std::monostate();
}

int OdometryPath::index(Key pose) const {
  const auto it = index_.find(pose);
  return it == index_.end() ? -1 : it->second;
}

std::optional<Prediction> OdometryPath::innovation(const ContinuousFactor& closure) const {
  return std::visit(
      [&](const auto& path) -> std::optional<Prediction> {
        if constexpr (std::is_same_v<std::decay_t<decltype(path)>, std::monostate>) {
          return std::nullopt;
        } else {
          using Pose = typename std::decay_t<decltype(path.poses)>::value_type;
          if (!is_between<Pose>(closure)) return std::nullopt;
          const int a = index(closure.keys()[0]), b = index(closure.keys()[1]);
          if (a < 0 || b < 0 || path.part[a] != path.part[b]) return std::nullopt;
          return innovation_at(closure, path.poses[a], motion<Pose>(path, a, b));
        }
      },
      path_);
}

}  // namespace hybrid
