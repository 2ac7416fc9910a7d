// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/motion_covariance.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/landmarks/landmark_association.h"
#include "libhybrid/smoother/proposal.h"

namespace hybrid::testing {

/// Holds the graph of an association, and turns down what is on trial as it is told to.
struct TrialHost {
  enum class Verdict { kByTheMap, kNever, kImpossible };

  explicit TrialHost(Verdict verdict = Verdict::kByTheMap, ClassModel classes = {})
      : association(AssociationOptions{}, std::move(classes)), verdict_(verdict) {}

  /// A keyframe. What it would have been with `refused` in place of what is seen comes before it,
  /// and is refused.
  void add(const SE2& motion, const Noise& noise, const std::vector<DetectionFrame>& seen,
           const std::vector<DetectionFrame>& refused = {}) {
    const auto i = static_cast<std::uint64_t>(keyframes++);
    const Key now(key_letter::kPose, i);
    SE2 place = motion;
    ContinuousFactorPtr factor = std::make_shared<Prior<SE2>>(now, motion, noise);
    if (i > 0) {
      const Key before(key_letter::kPose, i - 1);
      place = map.values().at<SE2>(before) * motion;
      factor = std::make_shared<BetweenSE2>(before, now, motion, noise);
    }
    Delta delta;
    delta.continuous.push_back(factor);
    delta.values.insert(now, place);
    const MapView before = view();
    KeyframeView frame{now, to_isometry(place), seen};
    const MotionCovariance after(*factor, now, delta.values, map.values(), before.covariance_of);
    frame.joint_covariance = after;
    frame.covariance_of = after;
    if (!refused.empty()) {
      refuse({now, frame.T_map_robot, refused, frame.joint_covariance, frame.covariance_of},
             before);
    }
    const Contribution out = association.observe(frame, before);
    map.update(delta);
    apply(out);
    change_until_done([this] { return association.revise(view()); });
  }
  void finish() {
    change_until_done([this] { return association.conclude(view()); });
  }

  double statistic(const char* name) const {
    const auto all = association.statistics();
    const auto it = all.find(name);
    return it == all.end() ? 0 : it->second;
  }

  MapView view() const {
    MapView out{map.values(), map.assignment(), landmarks, false};
    out.holds = [this](Key key) { return map.values().contains(key); };
    out.joint_covariance = [this](const std::vector<Key>& keys) {
      return map.joint_covariance(keys);
    };
    out.covariance_of = [this](const std::vector<Key>& keys, const Eigen::MatrixXd& J) {
      return map.joint_covariance(keys, J);
    };
    return out;
  }

  IncrementalSmoother map;
  LandmarkRegistry landmarks;
  LandmarkAssociation association;
  int keyframes = 0, proposals = 0, thrown = 0;

 private:
  template <class Next>
  void change_until_done(const Next& next) {
    for (Contribution change = next(); !change.empty(); change = next()) apply(change);
  }
  void refuse(const KeyframeView& frame, const MapView& before) {
    try {
      association.observe(frame, before);
    } catch (const Error&) {
      ++thrown;
    }
    association.refused();
  }
  void apply(const Contribution& change) {
    enter(change, landmarks);
    const double before = map.objective();
    UpdateReport report;
    if (change.allowed_rise) {
      ++proposals;
      const double allowed = verdict_ == Verdict::kByTheMap ? *change.allowed_rise
                                                            : -std::numeric_limits<double>::max();
      Delta delta = change.delta;
      if (verdict_ == Verdict::kImpossible) {  // leaves a variable undetermined
        delta.values.insert(Key(key_letter::kPose, 1000000), SE2());
      }
      report = propose(map, {delta, allowed});
    } else {
      report = map.update(change.delta);
    }
    if (report.status != UpdateReport::Status::kOk) {
      landmarks.roll_back();
      association.refused();
      return;
    }
    landmarks.commit();
    if (change.settle) map.settle();
    association.applied({report.handles, before, map.objective(), report.exact});
  }

  Verdict verdict_;
};

}  // namespace hybrid::testing
