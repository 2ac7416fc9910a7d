// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/detail/closure_front.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>
#include <unordered_map>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/selection/detail/motion.h"

namespace hybrid {
namespace {

/// Closures of a batch by which the depth of the search is found.
constexpr std::size_t kProbes = 8;
/// Poses around an end of a closure that are looked at: at most so many, and this part of all,
/// since a small map is solved sooner than searched.
constexpr std::size_t kMostPoses = 2000;
constexpr std::size_t kPart = 8;
/// Multiplications for each of them in the time of a search, about.
constexpr double kWorkOfPose = 200.0;

template <class Pose>
class FrontOf : public ClosureFront {
 public:
  explicit FrontOf(const RobustProblem& problem)
      : problem_(problem), edge_of_(problem.closures.size(), -1) {
    for (const ContinuousFactorPtr& factor : problem.trusted) add(*factor, -1);
    for (std::size_t k = 0; k < problem.closures.size(); ++k) {
      add(*problem.closures[k], static_cast<int>(k));
    }
    index();
  }

  std::vector<Candidate> beyond(const std::vector<Candidate>& batch, const Known& known) override {
    in_ = known.admitted;
    limit_depth(batch, known);
    std::vector<Candidate> found;
    std::vector<int> queue;
    for (const Candidate& candidate : batch) {
      in_[candidate.closure] = true;
      queue.push_back(candidate.closure);
    }
    fewest_.assign(in_.size(), std::numeric_limits<int>::max());
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::size_t before = found.size();
      ask_near(queue[next], known, found);
      note_work(kWorkOfPose * double(balls_[0].nodes.size()));
      for (std::size_t f = before; f < found.size(); ++f) queue.push_back(found[f].closure);
    }
    return found;
  }

  Values chained(const Values& values, const std::vector<bool>& admitted) const override {
    Values result = values;
    std::vector<bool> done(keys_.size(), false);
    using Reached = std::tuple<double, int, int>;  // distance, vertex, edge
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
    for (std::size_t root = 0; root < keys_.size(); ++root) {
      queue.emplace(0.0, static_cast<int>(root), -1);
      while (!queue.empty()) {
        const auto [distance, vertex, by] = queue.top();
        queue.pop();
        if (done[vertex]) continue;
        done[vertex] = true;
        if (by >= 0) {
          const Edge& edge = edges_[by];
          const bool forward = edge.to == vertex;
          const Pose& step = edge.measured.mean;
          result.update(keys_[vertex],
                        result.template at<Pose>(keys_[forward ? edge.from : edge.to]) *
                            (forward ? step : step.inverse()));
        }
        for (int i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
          const Edge& edge = edges_[incident_[i]];
          if (edge.closure >= 0 && !admitted[edge.closure]) continue;
          const int next = edge.from == vertex ? edge.to : edge.from;
          if (!done[next]) queue.emplace(distance + rotation_variance(edge), next, incident_[i]);
        }
      }
    }
    note_work(kWorkOfPose * double(keys_.size()));
    return result;
  }

 private:
  struct Edge {
    int from, to;
    int closure;  // -1: trusted
    Motion<Pose> measured;
  };
  /// The poses with the shortest paths from one, by the number of measurements.
  struct Ball {
    struct Node {
      int vertex, parent, edge, hops;
    };
    std::vector<Node> nodes;
    std::vector<int> place;             // by vertex, valid if nodes[place[v]].vertex is v
    std::vector<Motion<Pose>> motions;  // from the centre, of the nodes that are
    std::vector<bool> composed;
  };

  void add(const ContinuousFactor& factor, int closure) {
    if (factor.keys().size() != 2 || factor.keys()[0] == factor.keys()[1]) return;
    const std::optional<RelativePose<Pose>> motion = relative_pose<Pose>(factor);
    if (!motion) return;
    const Eigen::LLT<typename Motion<Pose>::Matrix> llt(motion->information);
    if (llt.info() != Eigen::Success) return;
    if (closure >= 0) edge_of_[closure] = static_cast<int>(edges_.size());
    edges_.push_back({vertex(factor.keys()[0]),
                      vertex(factor.keys()[1]),
                      closure,
                      {motion->measured, llt.solve(Motion<Pose>::Matrix::Identity())}});
  }

  static double rotation_variance(const Edge& edge) {
    constexpr int kRotation = Pose::kDim - Pose::Point::RowsAtCompileTime;
    return edge.measured.covariance.template bottomRightCorner<kRotation, kRotation>().trace();
  }

  int vertex(Key key) {
    const auto [place, is_new] = vertices_.emplace(key, static_cast<int>(keys_.size()));
    if (is_new) keys_.push_back(key);
    return place->second;
  }

  /// Lists the edges of each vertex.
  void index() {
    begin_.assign(keys_.size() + 1, 0);
    for (const Edge& edge : edges_) {
      ++begin_[edge.from + 1];
      ++begin_[edge.to + 1];
    }
    for (std::size_t v = 0; v < keys_.size(); ++v) begin_[v + 1] += begin_[v];
    incident_.resize(begin_.back());
    std::vector<int> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      incident_[next[edges_[e].from]++] = static_cast<int>(e);
      incident_[next[edges_[e].to]++] = static_cast<int>(e);
    }
    size_ = std::clamp<std::size_t>(keys_.size() / kPart, 1, kMostPoses);
    for (Ball& ball : balls_) {
      ball.place.assign(keys_.size(), 0);
      ball.nodes.reserve(size_);
      ball.motions.resize(size_);
    }
  }

  bool contains(const Ball& ball, int vertex) const {
    const auto place = static_cast<std::size_t>(ball.place[vertex]);
    return place < ball.nodes.size() && ball.nodes[place].vertex == vertex;
  }

  /// Without the edge `left_out`.
  void grow(Ball& ball, int centre, int left_out) const {
    ball.nodes.clear();
    const auto reach = [&](int vertex, int parent, int edge, int hops) {
      if (contains(ball, vertex)) return;
      ball.place[vertex] = static_cast<int>(ball.nodes.size());
      ball.nodes.push_back({vertex, parent, edge, hops});
    };
    reach(centre, -1, -1, 0);
    ball.composed.assign(size_, false);
    ball.composed[0] = true;
    for (std::size_t next = 0; next < ball.nodes.size(); ++next) {
      const int vertex = ball.nodes[next].vertex;
      const int hops = ball.nodes[next].hops + 1;
      if (hops > depth_) return;
      for (int i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
        const Edge& edge = edges_[incident_[i]];
        if (incident_[i] == left_out || (edge.closure >= 0 && !in_[edge.closure])) continue;
        if (ball.nodes.size() == size_) return;
        reach(edge.from == vertex ? edge.to : edge.from, static_cast<int>(next), incident_[i],
              hops);
      }
    }
  }

  /// Balls are no deeper than where even a closure that fits perfectly would have too little
  /// evidence, by the path to the pose that is reached first at that depth.
  void limit_depth(const std::vector<Candidate>& batch, const Known& known) {
    depth_ = 0;
    int deepest = 0;
    const std::size_t count = std::min(batch.size(), kProbes);
    for (std::size_t c = 0; c < count; ++c) {
      const int e = edge_of_[batch[c].closure];
      if (e < 0) continue;
      const Edge& bridge = edges_[e];
      depth_ = std::numeric_limits<int>::max();
      grow(balls_[0], bridge.from, e);
      for (std::size_t a = 0; a < balls_[0].nodes.size(); ++a) {
        const int hops = balls_[0].nodes[a].hops;
        if (hops <= deepest) continue;
        const Motion<Pose>& there = motion(balls_[0], static_cast<int>(a), known);
        const Motion<Pose> perfect = {bridge.measured.mean,
                                      bridge.measured.covariance + there.covariance};
        if (evidence_for(bridge, perfect, known) <= known.needed) break;
        deepest = hops;
      }
    }
    depth_ = deepest;
  }

  /// The motion from the centre of a ball to one of its poses. The mean along measurements that the
  /// map has is that of the map.
  const Motion<Pose>& motion(Ball& ball, int node, const Known& known) const {
    if (ball.composed[node]) return ball.motions[node];
    const typename Ball::Node& there = ball.nodes[node];
    const Edge& edge = edges_[there.edge];
    Motion<Pose> step = edge.measured;
    if (edge.closure < 0 || known.admitted[edge.closure]) {
      step.mean = known.values.template at<Pose>(keys_[edge.from])
                      .between(known.values.template at<Pose>(keys_[edge.to]));
    }
    if (edge.to != there.vertex) step = step.inverse();
    ball.motions[node] = motion(ball, there.parent, known) * step;
    ball.composed[node] = true;
    return ball.motions[node];
  }

  /// Adds the open closures whose two ends are near the two ends of one that is in, and that agree
  /// with it.
  void ask_near(int closure, const Known& known, std::vector<Candidate>& found) {
    if (edge_of_[closure] < 0) return;
    const Edge& bridge = edges_[edge_of_[closure]];
    const auto is_asked = [&](const Edge& edge) {
      return edge.closure >= 0 && known.open[edge.closure] && !in_[edge.closure];
    };
    Ball &near = balls_[0], &far = balls_[1];
    grow(near, bridge.from, edge_of_[closure]);
    bool grown = false;
    for (std::size_t a = 0; a < near.nodes.size(); ++a) {
      const int vertex = near.nodes[a].vertex;
      for (int i = begin_[vertex]; i < begin_[vertex + 1]; ++i) {
        const Edge& edge = edges_[incident_[i]];
        if (!is_asked(edge)) continue;
        if (!grown) grow(far, bridge.to, edge_of_[closure]);
        grown = true;
        const bool forward = edge.from == vertex;
        const int other = forward ? edge.to : edge.from;
        if (!contains(far, other)) continue;
        const int b = far.place[other];
        const int hops = near.nodes[a].hops + far.nodes[b].hops;
        if (hops >= fewest_[edge.closure]) continue;
        fewest_[edge.closure] = hops;
        const Motion<Pose> across = motion(near, static_cast<int>(a), known).inverse() *
                                    bridge.measured * motion(far, b, known);
        const double evidence = evidence_for(edge, forward ? across : across.inverse(), known);
        if (evidence <= known.needed) continue;
        in_[edge.closure] = true;
        found.push_back({evidence, edge.closure});
      }
    }
  }

  double evidence_for(const Edge& edge, const Motion<Pose>& predicted, const Known& known) const {
    return hybrid::evidence_for(*problem_.closures[edge.closure], predicted, known.model);
  }

  const RobustProblem& problem_;
  std::unordered_map<Key, int> vertices_;
  std::vector<Key> keys_;
  std::vector<Edge> edges_;
  std::vector<int> edge_of_;           // by closure
  std::vector<int> begin_, incident_;  // edges of vertex v: incident_[begin_[v]] ..
  std::size_t size_ = 1;               // of a ball, at most
  std::array<Ball, 2> balls_;
  std::vector<bool> in_;
  int depth_ = 0;            // of balls
  std::vector<int> fewest_;  // measurements of the paths by which a closure was asked
};

}  // namespace

std::unique_ptr<ClosureFront> make_closure_front(const RobustProblem& problem) {
  for (const ContinuousFactorPtr& closure : problem.closures) {
    if (closure->relative_pose_2d()) return std::make_unique<FrontOf<SE2>>(problem);
    if (closure->relative_pose_3d()) return std::make_unique<FrontOf<SE3>>(problem);
  }
  return nullptr;
}

}  // namespace hybrid
