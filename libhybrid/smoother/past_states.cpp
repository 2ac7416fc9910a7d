// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/past_states.h"

#include <Eigen/Geometry>
#include <optional>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

void copy(Key key, const Values& from, Values& to) {
  to.insert(key, from.type(key), from.data(key));
}

/// The rigid motion that takes points to others, of least squares; nothing where these are too few.
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

  std::optional<Eigen::Isometry3d> solve() const {
    if (!fixed_) return std::nullopt;
    const auto n = static_cast<Eigen::Index>(from_.size());
    const Eigen::Map<const Eigen::Matrix3Xd> from(from_.front().data(), 3, n),
        to(to_.front().data(), 3, n);
    return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
  }

 private:
  std::vector<Eigen::Vector3d> from_, to_;
  bool fixed_ = false;
};

}  // namespace

PastStates::Departure::Departure(const std::vector<Key>& states, const std::vector<Key>& tied,
                                 const Values& values) {
  for (const Key key : states) copy(key, values, this->states);
  for (const Key key : tied) copy(key, values, this->tied);
}

Values PastStates::at(const Values& window) const {
  Values out;
  for (auto it = departures_.rbegin(); it != departures_.rend(); ++it) {
    RigidMotion motion;
    for (const Key key : it->tied.keys()) {
      const Values& now = window.contains(key) ? window : out;
      if (!now.contains(key)) continue;
      if (is_pose(now.type(key))) {
        motion.add(isometry_at(it->tied, key), isometry_at(now, key));
      } else {
        motion.add(point_at(it->tied, key), point_at(now, key));
      }
    }
    const auto moved = motion.solve();
    for (const Key key : it->states.keys()) {
      if (window.contains(key) || out.contains(key)) continue;
      const VariableType type = it->states.type(key);
      if (moved && is_pose(type)) {
        const bool is_3d = type.dim == SE3::kDim;
        insert_pose(out, key, *moved * isometry_at(it->states, key), is_3d);
      } else {
        copy(key, it->states, out);
      }
    }
  }
  return out;
}

}  // namespace hybrid
