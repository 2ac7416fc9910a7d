// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/closure_factors.h"

#include <memory>

#include "libhybrid/core/error.h"

namespace hybrid {

template <class Pose>
Uncertain<Pose> relation_in(const MapView& map, Key a, Key b) {
  Uncertain<Pose> out;
  out.motion = map.values.template at<Pose>(a).between(map.values.template at<Pose>(b));
  Eigen::MatrixXd J(Pose::kDim, 2 * Pose::kDim);
  J << -out.motion.inverse().adjoint(), Pose::Jacobian::Identity();
  try {
    out.covariance = map.covariance_of({a, b}, J);
  } catch (const SettingsError&) {
    out.covariance.setIdentity();  // a batch back-end, which solves at the end
  }
  return out;
}

template Uncertain<SE2> relation_in(const MapView&, Key, Key);
template Uncertain<SE3> relation_in(const MapView&, Key, Key);

void ClosureFactors::follow(const std::vector<bool>& accepted, const Add& add, bool may_leave,
                            Contribution& out) {
  handles_.resize(accepted.size());
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    if (accepted[k] == handles_[k].has_value()) continue;
    if (!accepted[k]) {
      if (!may_leave) continue;
      out.delta.remove.push_back(*handles_[k]);
      leaving_.push_back(k);
    } else if (add(k, out)) {
      coming_.push_back({k, out.delta.continuous.size() - 1});
      out.settle = true;
    }
  }
}

void ClosureFactors::applied(const Outcome& outcome) {
  for (const Asked& asked : coming_) {
    handles_[asked.closure] = outcome.handles.continuous[asked.factor];
  }
  for (const std::size_t k : leaving_) handles_[k].reset();
  forget();
}

void ClosureFactors::forget() {
  coming_.clear();
  leaving_.clear();
}

}  // namespace hybrid
