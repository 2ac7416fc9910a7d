// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_graph.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>

#include "libhybrid/io/write_file.h"
#include "libhybrid/pose_graph/graph_variables.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {
namespace {

class Writer {
 public:
  explicit Writer(const PoseGraph& graph) : graph_(graph) {
    std::vector<Key> keys = graph.values.keys();
    const auto add = [&](const auto& edges) {
      for (const auto& edge : edges) keys.insert(keys.end(), {edge.from, edge.to});
    };
    add(graph.poses2);
    add(graph.poses3);
    add(graph.points2);
    add(graph.points3);
    shift_landmarks(keys);
  }

  std::string run() {
    if (!graph_.points3.empty() || !graph_.priors3.empty() || !graph_.positions3.empty()) offsets();
    for (int s = 0; s < graph_.values.slot_count(); ++s) {
      if (graph_.values.occupied(s)) vertex(graph_.values.key(s));
    }
    for (Key key : graph_.fixed) {
      text_ += "FIX";
      id(key);
      text_ += '\n';
    }
    for (const auto& e : graph_.poses2) edge("EDGE_SE2", e);
    for (const auto& e : graph_.poses3) edge("EDGE_SE3:QUAT", e);
    for (const auto& e : graph_.points2) edge("EDGE_SE2_XY", e);
    for (const auto& e : graph_.points3) edge("EDGE_SE3_TRACKXYZ", e, " 0");
    for (const auto& p : graph_.priors2) prior("EDGE_PRIOR_SE2", p);
    for (const auto& p : graph_.priors3) prior("EDGE_SE3_PRIOR", p, " 0");
    for (const auto& p : graph_.positions2) {
      if (!p.lever_arm.isZero(0)) {
        throw Error("g2o has no form for a position in the plane with a lever arm, as of " +
                    to_string(p.pose) +
                    ": move the measurement to the pose, or write the graph in "
                    "space");
      }
      prior("EDGE_PRIOR_SE2_XY", p);
    }
    for (const auto& p : graph_.positions3) {
      prior("EDGE_SE3_XYZPRIOR", p, ' ' + std::to_string(arm(p.lever_arm)));
    }
    return std::move(text_);
  }

 private:
  void shift_landmarks(std::vector<Key>& keys) {
    std::sort(keys.begin(), keys.end());
    std::vector<std::uint64_t> poses, landmarks;
    for (Key key : keys)
      (key.letter() == key_letter::kLandmark ? landmarks : poses).push_back(key.index());
    std::vector<std::uint64_t> both;
    std::set_intersection(poses.begin(), poses.end(), landmarks.begin(), landmarks.end(),
                          std::back_inserter(both));
    if (!both.empty()) shift_ = poses.back() + 1;
  }

  /// Sensors: at the robot's origin first, then one for each lever arm.
  void offsets() {
    arms_ = {Eigen::Vector3d::Zero()};
    for (const auto& p : graph_.positions3) {
      if (arm(p.lever_arm) == arms_.size()) arms_.push_back(p.lever_arm);
    }
    for (std::size_t k = 0; k < arms_.size(); ++k) {
      text_ += "PARAMS_SE3OFFSET " + std::to_string(k);
      value(SE3(arms_[k], Eigen::Quaterniond::Identity()));
      text_ += '\n';
    }
  }
  std::size_t arm(const Eigen::Vector3d& lever_arm) const {
    return static_cast<std::size_t>(std::find(arms_.begin(), arms_.end(), lever_arm) -
                                    arms_.begin());
  }

  void id(Key key) {
    const std::uint64_t shift = key.letter() == key_letter::kLandmark ? shift_ : 0;
    text_ += ' ' + std::to_string(vertex_id(key.index() + shift));
  }

  void number(double x) {
    char buffer[32];
    text_ += ' ';
    text_.append(buffer, std::to_chars(buffer, buffer + sizeof buffer, x).ptr);
  }

  void value(const SE2& x) {
    number(x.x());
    number(x.y());
    number(x.angle());
  }
  void value(const SE3& x) {
    double v[SE3::kSize];
    x.store(v);
    for (double e : v) number(e);
  }
  template <int n>
  void value(const Eigen::Matrix<double, n, 1>& x) {
    for (int i = 0; i < n; ++i) number(x[i]);
  }

  template <class T>
  void vertex(std::string_view tag, Key key) {
    text_ += tag;
    id(key);
    value(graph_.values.at<T>(key));
    text_ += '\n';
  }

  void vertex(Key key) {
    const VariableType type = graph_.values.type(key);
    if (!is_pose_or_landmark(key, type)) {
      throw Error("g2o has no vertex for " + to_string(key) + ", a " + to_string(type) +
                  ": poses are x<id>, landmarks l<id>");
    }
    if (type == Variable<SE2>::type()) {
      vertex<SE2>("VERTEX_SE2", key);
    } else if (type == Variable<SE3>::type()) {
      vertex<SE3>("VERTEX_SE3:QUAT", key);
    } else if (type.dim == 2) {
      vertex<Eigen::Vector2d>("VERTEX_XY", key);
    } else {
      vertex<Eigen::Vector3d>("VERTEX_TRACKXYZ", key);
    }
  }

  template <class T>
  void edge(std::string_view tag, const GraphEdge<T>& e, std::string_view parameter = "") {
    text_ += tag;
    id(e.from);
    id(e.to);
    text_ += parameter;
    measurement(e.measured, e.noise);
  }

  template <class Measurement>
  void prior(std::string_view tag, const Measurement& p, std::string_view parameter = "") {
    text_ += tag;
    id(p.pose);
    text_ += parameter;
    measurement(p.measured, p.noise);
  }

  template <class T>
  void measurement(const T& measured, const Noise& noise) {
    value(measured);
    const Eigen::MatrixXd information = noise.information();
    for (int i = 0; i < information.rows(); ++i) {
      for (int j = i; j < information.cols(); ++j) number(information(i, j));
    }
    text_ += '\n';
  }

  const PoseGraph& graph_;
  std::string text_;
  std::uint64_t shift_ = 0;
  std::vector<Eigen::Vector3d> arms_;  // by the number of the sensor
};

}  // namespace

std::string to_g2o(const PoseGraph& graph) {
  return Writer(graph).run();
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  write_file(path, to_g2o(graph));
}

}  // namespace hybrid
