// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"

namespace hybrid::testing {

/// What a detector says of a tree and of a car.
inline const std::vector<double> kTree = {0.9, 0.1}, kCar = {0.1, 0.9};

/// Tracks in the plane, the graph that their contributions make, and a map as one may be told of
/// it: landmarks where they were put, each known to `sigma` [m] and independent of the others.
struct TrackGraph {
  ClassModel classes;
  LandmarkTracks tracks;
  HybridGraph graph;
  Values values;
  Assignment assignment;
  LandmarkRegistry registry;
  double sigma = 0.1, pose_sigma = 0.01;  // [m], [rad] for the angle of the pose too
  double noise = 1;                       // factor of the variances of what is seen from now on
  int frames = 0;

  explicit TrackGraph(std::vector<std::string> names = {"tree", "car"}) {
    if (!names.empty()) classes.learn_names(names);
  }

  /// Notes that `point` was seen from the origin, in a frame of its own unless told otherwise.
  int see(const Eigen::Vector2d& point, std::vector<double> phi = {}, int frame = -1) {
    Sighting s;
    s.frame = frame < 0 ? ++frames : frame;
    s.pose = Key(key_letter::kPose, static_cast<std::uint64_t>(s.frame));
    auto sensor = std::make_shared<DetectionFrame>();
    sensor->is_3d = false;
    s.sensor = sensor;
    s.detection.range = point.norm();
    s.detection.yaw = std::atan2(point.y(), point.x());
    s.detection.covariance.diagonal() << 0.01 * noise, 1e-4 * noise, 0;
    s.phi = std::move(phi);
    return tracks.note(std::move(s));
  }

  int create(int sighting, Contribution& out) {
    return tracks.create(sighting, Eigen::Isometry3d::Identity(), classes, false, out);
  }

  /// A landmark that was seen `times` times, each in a frame of its own; part of the graph.
  int landmark(const Eigen::Vector2d& point, const std::vector<double>& phi = {}, int times = 1) {
    Contribution out;
    const int t = create(see(point, phi), out);
    for (int i = 1; i < times; ++i) tracks.attach(see(point, phi), t, false, out);
    apply(out);
    tracks.track(t).sigma = std::sqrt(2.0) * sigma;
    return t;
  }

  /// What a smoother does with a contribution, but for solving.
  void apply(const Contribution& out) {
    for (const Handle handle : out.delta.remove) graph.remove(handle);
    AddedHandles handles;
    for (const auto& factor : out.delta.continuous) handles.continuous.push_back(graph.add(factor));
    for (const auto& table : out.delta.discrete) handles.discrete.push_back(graph.add(table));
    for (const auto& factor : out.delta.hybrid) handles.hybrid.push_back(graph.add(factor));
    for (const Key key : out.delta.values.keys()) {
      values.insert(key, out.delta.values.type(key), out.delta.values.data(key));
    }
    for (const Key key : out.delta.remove_values) values.erase(key);
    for (const auto& [key, value] : out.delta.assignment) assignment.set(key, value);
    enter(out, registry);
    registry.commit();
    tracks.take_handles(handles);
  }

  MapView map() const {
    MapView view{values, assignment, registry, false};
    view.holds = [this](Key key) { return values.contains(key); };
    view.joint_covariance = [this](const std::vector<Key>& keys) { return joint(keys, false); };
    view.covariance_of = [this](const std::vector<Key>& keys,
                                const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
      return J * joint(keys, false) * J.transpose();
    };
    return view;
  }
  /// A keyframe at the origin.
  KeyframeView keyframe(Key pose, const std::vector<DetectionFrame>& detections) const {
    KeyframeView view{pose, Eigen::Isometry3d::Identity(), detections};
    view.joint_covariance = [this](const std::vector<Key>& keys) { return joint(keys, true); };
    view.covariance_of = [this](const std::vector<Key>& keys,
                                const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
      return J * joint(keys, true) * J.transpose();
    };
    return view;
  }

 private:
  Eigen::MatrixXd joint(const std::vector<Key>& keys, bool with_pose) const {
    std::vector<double> variances(with_pose ? 3 : 0, pose_sigma * pose_sigma);
    for (const Key key : keys) {
      const int dim = values.type(key).dim;
      variances.insert(variances.end(), dim, (dim == 3 ? pose_sigma * pose_sigma : sigma * sigma));
    }
    return Eigen::Map<const Eigen::VectorXd>(variances.data(), Eigen::Index(variances.size()))
        .asDiagonal();
  }
};

}  // namespace hybrid::testing
