// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/past_states.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/geometry/so3.h"

namespace hybrid {
namespace {

constexpr double kShareOfSigma = 0.5;  // by which a tie moves before what hangs on it follows

void copy(Key key, const Values& from, Values& to) {
  to.insert(key, from.type(key), from.data(key));
}

/// The rigid motion that takes points to others, of least squares; fixed once there is a pose.
class RigidMotion {
 public:
  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    from_.push_back(from);
    to_.push_back(to);
  }
  /// A pose fixes a motion by itself: it stands for its origin and the ends of its axes [m].
  void add(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
    add(Eigen::Vector3d(from.translation()), Eigen::Vector3d(to.translation()));
    for (int i = 0; i < 3; ++i) {
      add(Eigen::Vector3d(from * Eigen::Vector3d::Unit(i)),
          Eigen::Vector3d(to * Eigen::Vector3d::Unit(i)));
    }
    fixed_ = true;
  }

  bool is_fixed() const { return fixed_; }
  Eigen::Isometry3d solve() const {
    const auto n = static_cast<Eigen::Index>(from_.size());
    const Eigen::Map<const Eigen::Matrix3Xd> from(from_.front().data(), 3, n),
        to(to_.front().data(), 3, n);
    return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
  }
  /// Mean squared distance that a motion leaves, and that of the points from their mean [m^2].
  std::pair<double, double> spread(const Eigen::Isometry3d& motion) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : from_) mean += p / static_cast<double>(from_.size());
    double off = 0.0, wide = 0.0;
    for (std::size_t i = 0; i < from_.size(); ++i) {
      off += (to_[i] - motion * from_[i]).squaredNorm() / static_cast<double>(from_.size());
      wide += (from_[i] - mean).squaredNorm() / static_cast<double>(from_.size());
    }
    return {off, wide};
  }

 private:
  std::vector<Eigen::Vector3d> from_, to_;
  bool fixed_ = false;
};

/// A motion of what is tied to some states, and how well it is known at these.
struct Motion {
  Eigen::Isometry3d T;
  double off = 0.0, wide = 0.0;  // as RigidMotion::spread
};

/// The tangent of a variable by one of `pose` that moves both rigidly; zero if it has no place.
template <class Pose>
Eigen::MatrixXd carried(Key key, const Values& values, const Pose& pose) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  const VariableType type = values.type(key);
  if (type == Variable<Pose>::type()) return values.at<Pose>(key).between(pose).adjoint();
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(type.dim, Pose::kDim);
  if (type != Variable<typename Pose::Point>::type()) return D;
  const auto R = pose.rotation().matrix();
  const typename Pose::Point arm = pose.inverse() * values.at<typename Pose::Point>(key);
  D.template leftCols<kPosition>() = R;
  if constexpr (kPosition == 2) {
    D.rightCols(1) = R * Eigen::Vector2d(-arm.y(), arm.x());
  } else {
    D.rightCols(3) = -R * hat(arm);
  }
  return D;
}

/// See PastStates::Departure::follows; `rows` are those of the pose in Marginalization::follows.
template <class Pose>
Eigen::MatrixXd follows(const Pose& pose, const Eigen::MatrixXd& rows,
                        const std::vector<Key>& separator, const Values& values) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(Pose::kDim, Pose::kDim);
  Eigen::Index at = 0;
  for (const Key key : separator) {
    const int dim = values.type(key).dim;
    out += rows.middleCols(at, dim) * carried(key, values, pose);
    at += dim;
  }
  return out;
}

SE2 moved_by(const Eigen::Isometry3d& T, const SE2& pose) {
  return to_se2(T * to_isometry(pose));
}
SE3 moved_by(const Eigen::Isometry3d& T, const SE3& pose) {
  return to_se3(T * to_isometry(pose));
}

/// A pose after a motion, of which it had the covariance C before: a displacement normal with C,
/// measured by the motion, which it follows by F.
template <class Pose>
Pose moved(const Pose& pose, const Motion& motion, const Eigen::MatrixXd& F,
           const Eigen::MatrixXd& C) {
  constexpr int kPosition = Pose::Point::RowsAtCompileTime;
  const typename Pose::Tangent d = pose.between(moved_by(motion.T, pose)).log();
  Eigen::Matrix<double, Pose::kDim, Pose::kDim> S = C;
  S.diagonal().template head<kPosition>().array() += motion.off;
  S.diagonal().template tail<Pose::kDim - kPosition>().array() += motion.off / motion.wide;
  const typename Pose::Tangent step = F * (C * S.completeOrthogonalDecomposition().solve(d));
  return pose * Pose::exp(step);
}

/// How far a variable has moved [m], a pose with the ends of its axes in the plane.
double way_between(Key key, const Values& before, const Values& now) {
  if (!is_pose(now.type(key))) return (point_at(before, key) - point_at(now, key)).norm();
  const Eigen::Isometry3d from = isometry_at(before, key), to = isometry_at(now, key);
  double way = (from.translation() - to.translation()).norm();
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d end = Eigen::Vector3d::Unit(i);
    way = std::max(way, (from * end - to * end).norm());
  }
  return way;
}

}  // namespace

PastStates::Departure::Departure(const Marginalization& made, const std::vector<Key>& tied,
                                 const Values& values) {
  Eigen::Index at = 0;
  double most = 0;  // information on a position [1/m^2]
  for (const Key key : made.delta.remove_values) {
    copy(key, values, states);
    const VariableType type = values.type(key);
    if (is_pose(type)) {
      most = std::max(most, made.information.segment(at, type.dim == SE3::kDim ? 3 : 2).mean());
    }
    const auto rows = made.follows.middleRows(at, type.dim);
    if (type == Variable<SE2>::type()) {
      follows[key] = hybrid::follows(values.at<SE2>(key), rows, made.separator, values);
    } else if (type == Variable<SE3>::type()) {
      follows[key] = hybrid::follows(values.at<SE3>(key), rows, made.separator, values);
    }
    at += type.dim;
  }
  for (const Key key : tied) copy(key, values, this->tied);
  step = most > 0 ? kShareOfSigma / std::sqrt(most) : kInfinity;
}

void PastStates::leave(Departure departure) {
  for (const Key key : departure.states.keys()) {
    if (told_.contains(key)) told_.erase(key);
    copy(key, departure.states, told_);
    departure_of_[key] = departures_.size();
  }
  for (const Key key : departure.tied.keys()) {
    Followers& followers = ties_[key][std::ilogb(departure.step)];
    followers.departures.push_back(departures_.size());
    if (!followers.followed.contains(key)) copy(key, departure.tied, followers.followed);
  }
  departures_.push_back(std::move(departure));
}

void PastStates::move(const Departure& departure, const Values& window, const Values& past,
                      const std::unordered_map<Key, Eigen::MatrixXd>& covariances, Values& out) {
  RigidMotion motion;
  for (const Key key : departure.tied.keys()) {
    const Values& now = window.contains(key) ? window : past;
    if (!now.contains(key)) continue;
    if (is_pose(now.type(key))) {
      motion.add(isometry_at(departure.tied, key), isometry_at(now, key));
    } else {
      motion.add(point_at(departure.tied, key), point_at(now, key));
    }
  }
  Motion how;
  if (motion.is_fixed()) {
    how.T = motion.solve();
    std::tie(how.off, how.wide) = motion.spread(how.T);
  }
  for (const Key key : departure.states.keys()) {
    if (window.contains(key) || out.contains(key)) continue;
    const Values& states = departure.states;
    const VariableType type = states.type(key);
    if (motion.is_fixed() && type == Variable<SE2>::type()) {
      out.insert(key,
                 moved(states.at<SE2>(key), how, departure.follows.at(key), covariances.at(key)));
    } else if (motion.is_fixed() && type == Variable<SE3>::type()) {
      out.insert(key,
                 moved(states.at<SE3>(key), how, departure.follows.at(key), covariances.at(key)));
    } else {
      copy(key, states, out);
    }
  }
}

Values PastStates::at(const Values& window,
                      const std::unordered_map<Key, Eigen::MatrixXd>& covariances) const {
  Values out;
  for (auto it = departures_.rbegin(); it != departures_.rend(); ++it) {
    move(*it, window, out, covariances, out);
  }
  return out;
}

/// Lets what hangs on a variable wait for its turn, once the variable has moved far enough.
void PastStates::ask(Key key, const Values& now) {
  const auto tie = ties_.find(key);
  if (tie == ties_.end() || !now.contains(key)) return;
  for (auto& [exponent, followers] : tie->second) {
    if (!(way_between(key, followers.followed, now) > std::ldexp(1.0, exponent))) continue;
    followers.followed = {};
    copy(key, now, followers.followed);
    // What left later comes first, since earlier departures hang on it.
    for (auto it = followers.departures.rbegin(); it != followers.departures.rend(); ++it) {
      if (std::exchange(departures_[*it].waits, true)) continue;
      waiting_.push_back(*it);
    }
  }
}

Values PastStates::follow(const Values& window, const std::vector<Key>& changed,
                          const std::unordered_map<Key, Eigen::MatrixXd>& covariances) {
  for (const Key key : changed) ask(key, window.contains(key) ? window : told_);
  Values out;
  for (std::size_t told = 0; !waiting_.empty() && told <= changed.size();) {
    const std::size_t first = waiting_.front();
    waiting_.pop_front();
    departures_[first].waits = false;
    Values states;
    move(departures_[first], window, told_, covariances, states);
    for (const Key key : states.keys()) {
      ++told;
      if (departure_of_.at(key) != first) continue;  // it came back, and left again later
      std::copy_n(states.data(key), states.type(key).size, told_.data(told_.slot(key)));
      if (out.contains(key)) out.erase(key);
      copy(key, told_, out);
      ask(key, told_);
    }
  }
  return out;
}

}  // namespace hybrid
