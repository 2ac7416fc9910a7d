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
    if (!graph_.points3.empty()) text_ += "PARAMS_SE3OFFSET 0 0 0 0 0 0 0 1\n";
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

  void id(Key key) {
    text_ +=
        ' ' + std::to_string(key.index() + (key.letter() == key_letter::kLandmark ? shift_ : 0));
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
    value(e.measured);
    const Eigen::MatrixXd information = e.noise.information();
    for (int i = 0; i < information.rows(); ++i) {
      for (int j = i; j < information.cols(); ++j) number(information(i, j));
    }
    text_ += '\n';
  }

  const PoseGraph& graph_;
  std::string text_;
  std::uint64_t shift_ = 0;
};

}  // namespace

std::string to_g2o(const PoseGraph& graph) {
  return Writer(graph).run();
}

void write_g2o(const std::string& path, const PoseGraph& graph) {
  write_file(path, to_g2o(graph));
}

}  // namespace hybrid
