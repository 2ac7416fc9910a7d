// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/correlative_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <queue>

namespace hybrid {
namespace {

/// Points nearer than this do not refine the step of the angle [m].
constexpr double kNearPoint = 3.0;
/// Of the points, this share turns by less than a cell in one step of the angle.
constexpr double kShareOfPoints = 0.8;

/// A square of translations at one angle: cells [x, x + 2^level) by [y, y + 2^level), relative to
/// the centre.
struct Node {
  double bound = 0.0;
  int level = 0, angle = 0, x = 0, y = 0;
};

/// Best bound first; then finer, then a fixed order.
struct IsWorse {
  bool operator()(const Node& a, const Node& b) const {
    if (a.bound != b.bound) return a.bound < b.bound;
    if (a.level != b.level) return a.level > b.level;
    if (a.angle != b.angle) return a.angle > b.angle;
    return a.x != b.x ? a.x > b.x : a.y > b.y;
  }
};

class BranchAndBound {
 public:
  BranchAndBound(const std::vector<Eigen::Vector2d>& points, const LikelihoodField& field,
                 const SearchWindow& window, const SearchOptions& options)
      : points_(points), field_(field), window_(window), options_(options) {
    cells_x_ = static_cast<int>(std::ceil(window.reach.x() / field.resolution()));
    cells_y_ = static_cast<int>(std::ceil(window.reach.y() / field.resolution()));
    turn_points();
  }

  std::vector<SearchMode> run() {
    for (std::size_t a = 0; a < cells_.size(); ++a) start_angle(static_cast<int>(a));
    while (!open_.empty() && static_cast<int>(modes_.size()) < options_.max_modes) {
      const Node node = open_.top();
      open_.pop();
      if (node.bound < least()) break;
      if (is_known(node)) continue;
      if (node.level == 0) {
        modes_.push_back({pose_of(node), node.bound});
      } else if (scored_ < options_.budget) {
        split(node);
      }
    }
    return modes_;
  }

 private:
  void turn_points() {
    std::vector<double> ranges;
    ranges.reserve(points_.size());
    for (const Eigen::Vector2d& p : points_) ranges.push_back(p.norm());
    const auto k = static_cast<std::size_t>(kShareOfPoints * double(ranges.size() - 1));
    std::nth_element(ranges.begin(), ranges.begin() + k, ranges.end());
    step_ = field_.resolution() / std::max(ranges[k], kNearPoint);
    steps_ = static_cast<int>(std::ceil(window_.turn / step_));
    for (int a = -steps_; a <= steps_; ++a) {
      const SE2 pose(window_.centre.translation(), turned(a));
      std::vector<Eigen::Vector2i> cells;
      cells.reserve(points_.size());
      for (const Eigen::Vector2d& p : points_) cells.push_back(field_.cell(pose * p));
      cells_.push_back(std::move(cells));
    }
  }

  SO2 turned(int a) const { return window_.centre.rotation() * SO2(a * step_); }

  SE2 pose_of(const Node& node) const {
    const Eigen::Vector2d shift(node.x, node.y);
    return {window_.centre.translation() + field_.resolution() * shift,
            turned(node.angle - steps_)};
  }

  double least() const {
    return modes_.empty() ? options_.min_score
                          : std::max(options_.min_score, options_.ratio * modes_.front().score);
  }

  void push(int level, int angle, int x, int y) {
    if (x > cells_x_ || y > cells_y_) return;
    long sum = 0;
    for (const Eigen::Vector2i& c : cells_[angle]) sum += field_.at(level, c.x() + x, c.y() + y);
    ++scored_;
    const double bound = double(sum) / (255.0 * double(points_.size()));
    if (bound >= least()) open_.push({bound, level, angle, x, y});
  }

  void start_angle(int angle) {
    const int span = 2 * std::max(cells_x_, cells_y_) + 1;
    int level = 0;
    while (level + 1 < field_.levels() && (1 << level) < span) ++level;
    for (int y = -cells_y_; y <= cells_y_; y += 1 << level) {
      for (int x = -cells_x_; x <= cells_x_; x += 1 << level) push(level, angle, x, y);
    }
  }

  void split(const Node& node) {
    const int half = 1 << (node.level - 1);
    for (const int dy : {0, half}) {
      for (const int dx : {0, half}) push(node.level - 1, node.angle, node.x + dx, node.y + dy);
    }
  }

  /// Whether all poses of a node belong to a mode that has been found.
  bool is_known(const Node& node) const {
    Node far = node;
    far.x += (1 << node.level) - 1;
    far.y += (1 << node.level) - 1;
    return std::any_of(modes_.begin(), modes_.end(), [&](const SearchMode& mode) {
      return is_same(mode.pose, pose_of(node)) && is_same(mode.pose, pose_of(far));
    });
  }

  bool is_same(const SE2& a, const SE2& b) const {
    const Eigen::Vector2d d = a.translation() - b.translation();
    return d.cwiseAbs().maxCoeff() < options_.same_translation &&
           std::abs((a.rotation().inverse() * b.rotation()).angle()) < options_.same_rotation;
  }

  const std::vector<Eigen::Vector2d>& points_;
  const LikelihoodField& field_;
  const SearchWindow& window_;
  const SearchOptions& options_;
  int cells_x_ = 0, cells_y_ = 0, steps_ = 0, scored_ = 0;
  double step_ = 0.0;
  std::vector<std::vector<Eigen::Vector2i>> cells_;  // of the points, by angle
  std::priority_queue<Node, std::vector<Node>, IsWorse> open_;
  std::vector<SearchMode> modes_;
};

}  // namespace

std::vector<SearchMode> search_poses(const std::vector<Eigen::Vector2d>& points,
                                     const LikelihoodField& field, const SearchWindow& window,
                                     const SearchOptions& options) {
  if (points.empty() || field.empty()) return {};
  return BranchAndBound(points, field, window, options).run();
}

}  // namespace hybrid
