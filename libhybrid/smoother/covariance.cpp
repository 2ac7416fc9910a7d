// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Covariances of the smoother, from its Bayes tree.
#include <algorithm>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

/// What J x is by tangents at the linearisation points, J being its derivative by those at the
/// estimate. The tree leaves a rigid motion of the map free at its linearisation points. J has to
/// leave it free too, or a kilometre of drift enters by whatever these and the estimate differ:
/// so tangents are taken from the one to the other as a rigid motion would move them. A pose knows
/// how it turns; a point turns with the pose `anchor`.
template <class Pose>
class Transport {
 public:
  Transport(const Values& from, const Values& to, const Pose& anchor)
      : from_(from), to_(to), turn_(turn_of(anchor)) {}

  /// Changes the columns of variable `key` from `own` on; those of the anchor begin at `anchor`.
  void move(Key key, Eigen::Index own, Eigen::Index anchor, Eigen::MatrixXd& J) const {
    const VariableType type = from_.type(key);
    if (type.kind == Variable<Pose>::type().kind) {
      move_pose(from_.at<Pose>(key), to_.at<Pose>(key), own, J);
    } else if (type.kind == VariableKind::kVector && type.dim == kDim) {
      const Point way = to_.at<Point>(key) - from_.at<Point>(key);
      J.middleCols<kTurn>(anchor + kDim) += J.middleCols<kDim>(own) * by_turn(way) * turn_;
    }
  }

 private:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;
  static constexpr int kTurn = Pose::kDim - kDim;
  using Point = typename Pose::Point;
  using Turn = Eigen::Matrix<double, kTurn, kTurn>;

  /// A turn in the tangent of a pose, as one of the map.
  static Turn turn_of(const Pose& pose) {
    if constexpr (kTurn == 1) {
      return Turn::Identity();
    } else {
      return pose.rotation().matrix();
    }
  }

  /// How an arrow of the map changes with a turn of the map.
  static Eigen::Matrix<double, kDim, kTurn> by_turn(const Point& arrow) {
    Eigen::Matrix<double, kDim, kTurn> out;
    if constexpr (kTurn == 1) {
      out << -arrow.y(), arrow.x();
    } else {
      out << 0, arrow.z(), -arrow.y(), -arrow.z(), 0, arrow.x(), arrow.y(), -arrow.x(), 0;
    }
    return out;
  }

  static void move_pose(const Pose& from, const Pose& to, Eigen::Index own, Eigen::MatrixXd& J) {
    const auto back = to.rotation().matrix().transpose().eval();
    typename Pose::Jacobian D = Pose::Jacobian::Zero();
    D.template topLeftCorner<kDim, kDim>() = back * from.rotation().matrix();
    D.template topRightCorner<kDim, kTurn>() =
        back * by_turn(to.translation() - from.translation()) * turn_of(from);
    D.template bottomRightCorner<kTurn, kTurn>() = turn_of(to).transpose() * turn_of(from);
    J.middleCols<Pose::kDim>(own) = (J.middleCols<Pose::kDim>(own) * D).eval();
  }

  const Values& from_;
  const Values& to_;
  Turn turn_;
};

template <class Pose>
Eigen::MatrixXd transported(const std::vector<Key>& keys, Eigen::MatrixXd J, std::size_t anchor,
                            const Values& theta, const Values& estimate) {
  const Transport<Pose> transport(theta, estimate, theta.at<Pose>(keys[anchor]));
  std::vector<Eigen::Index> first{0};
  for (Key key : keys) first.push_back(first.back() + theta.type(key).dim);
  // Poses first: what points add to the anchor is in its tangent at the linearisation point.
  for (const bool poses : {true, false}) {
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (is_pose(theta.type(keys[k])) == poses)
        transport.move(keys[k], first[k], first[anchor], J);
    }
  }
  return J;
}

/// J with its columns by tangents at the linearisation points rather than at the estimate.
Eigen::MatrixXd transported(const std::vector<Key>& keys, const Eigen::MatrixXd& J,
                            const Values& theta, const Values& estimate) {
  const auto pose =
      std::find_if(keys.begin(), keys.end(), [&](Key key) { return is_pose(theta.type(key)); });
  if (pose == keys.end()) return J;
  const auto anchor = static_cast<std::size_t>(pose - keys.begin());
  return theta.type(*pose).kind == VariableKind::kSE2
             ? transported<SE2>(keys, J, anchor, theta, estimate)
             : transported<SE3>(keys, J, anchor, theta, estimate);
}

/// A covariance by tangents at the linearisation points, by those at the estimate.
Eigen::MatrixXd moved_along(const std::vector<Key>& keys, const Eigen::MatrixXd& covariance,
                            const Values& theta, const Values& estimate) {
  if (std::all_of(keys.begin(), keys.end(), [&](Key key) {
        const double* x = theta.data(key);
        return std::equal(x, x + theta.type(key).size, estimate.data(key));
      }))
    return covariance;
  const Eigen::MatrixXd D = transported(
      keys, Eigen::MatrixXd::Identity(covariance.rows(), covariance.rows()), theta, estimate);
  return D * covariance * D.transpose();
}

}  // namespace

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys) const {
  if (!tree_is_whole()) return ContinuousMarginals(graph_, estimate()).joint_covariance(keys);
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(theta_->slot(key));
  return moved_along(keys, tree_.joint_covariance(slots), theta_.get(), values());
}

Eigen::MatrixXd IncrementalSmoother::joint_covariance(const std::vector<Key>& keys,
                                                      const Eigen::MatrixXd& J) const {
  if (!tree_is_whole()) return J * joint_covariance(keys) * J.transpose();
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(theta_->slot(key));
  return tree_.joint_covariance(slots, transported(keys, J, theta_.get(), values()));
}

void IncrementalSmoother::visit_covariances(
    const std::function<void(Key, const Eigen::MatrixXd&)>& visit) const {
  if (!tree_is_whole()) {
    const Covariances all = ContinuousMarginals(graph_, estimate()).all();
    for (Key key : values().keys()) {
      if (all.contains(key)) visit(key, all.at(key));
    }
    return;
  }
  tree_.visit_covariances([&](int slot, const Eigen::MatrixXd& covariance) {
    const Key key = theta_->key(slot);
    visit(key, moved_along({key}, covariance, theta_.get(), values()));
  });
}

}  // namespace hybrid
