// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/pose_charts.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/geometry/pose_step.h"
#include "libhybrid/smoother/detail/located.h"

namespace hybrid {
namespace {

/// A rigid motion of the map applied to a variable: poses of its kind and points of its dimension
/// move, all else stays.
template <class Pose>
void move_with_map(const Pose& motion, VariableType type, double* x) {
  constexpr int kPointDim = Pose::Point::RowsAtCompileTime;
  if (type.kind == Variable<Pose>::type().kind) {
    Pose moved = motion * Pose::load(x);
    moved.normalize();
    moved.store(x);
  } else if (type.kind == VariableKind::kVector && type.dim == kPointDim) {
    using Point = typename Pose::Point;
    const Point moved = motion * Point(Eigen::Map<const Point>(x));
    Eigen::Map<Point>{x} = moved;
  }
}

/// From the map into the frame of a chart.
template <class Pose>
struct Back {
  bool beside_points;
  bool moved;
  Pose motion;
  Back(Chart chart, bool has_points)
      : beside_points(has_points),
        moved(chart.is_moved()),
        motion(moved ? Pose::load(chart.motion + 1).inverse() : Pose()) {}

  /// A pose as its point of the chart sees it.
  Pose from_point(const double* point, const double* x) const {
    return Pose::load(point).between(moved ? motion * Pose::load(x) : Pose::load(x));
  }

  void see(VariableType type, const double* point, const double* x, double* step) const {
    using Point = typename Pose::Point;
    if (type.kind == Variable<Pose>::type().kind) {
      Eigen::Map<typename Pose::Tangent>{step} = step_over(from_point(point, x), beside_points);
    } else if (moved && type.kind == VariableKind::kVector &&
               type.dim == Pose::Point::RowsAtCompileTime) {
      const Point at = motion * Point(Eigen::Map<const Point>(x));
      Eigen::Map<Point>{step} = at - Eigen::Map<const Point>(point);
    } else {
      local(type, point, x, step);
    }
  }
};

/// The charts of a map of poses and points. A chart is whether it has moved, its motion, and the
/// points of its variables, one after the other.
template <class Pose>
class PoseCharts : public Charts {
 public:
  PoseCharts(const Values& values, JournaledValues* estimate, const MapVariables& variables,
             bool has_points)
      : values_(values), estimate_(estimate), variables_(variables), has_points_(has_points) {}

  std::size_t size(const std::vector<int>& variables) const override {
    std::size_t size = 0;
    for (int v : variables) size += values_.type(v).size;
    return size;
  }

  void start(const std::vector<int>& variables, double* points) const override {
    for (int v : variables) points = std::copy_n(values_.data(v), values_.type(v).size, points);
  }

  void see(const std::vector<int>& variables, int first, Chart chart,
           double* steps) const override {
    const Back<Pose> back(chart, has_points_);
    const double* point = point_of(variables, first, chart);
    for (auto v = variables.begin() + first; v != variables.end(); ++v) {
      const VariableType type = values_.type(*v);
      back.see(type, point, values_.data(*v), steps);
      point += type.size;
      steps += type.dim;
    }
  }

  void see(const std::vector<int>& variables, int first, int anchor_from, Chart chart,
           double* steps, Turn& turn) const override {
    const Back<Pose> back(chart, has_points_);
    const auto count = static_cast<int>(variables.size());
    int anchor = first_pose(variables, anchor_from);
    if (anchor == count) anchor = first_pose(variables, first);
    const bool points = std::any_of(variables.begin() + first, variables.end(),
                                    [this](int v) { return is_point(values_.type(v)); });
    turn.anchor = points && anchor < count ? anchor : -1;
    turn.own.clear();
    turn.by_anchor.clear();
    const Point way =
        anchor < count ? turning_point(variables, anchor, chart, back) : Point::Zero();
    const double* point = point_of(variables, first, chart);
    for (int k = first; k < count; ++k) {
      const VariableType type = values_.type(variables[k]);
      const double* x = values_.data(variables[k]);
      const std::size_t own = turn.own.size(), by = turn.by_anchor.size();
      turn.own.resize(own + type.dim * type.dim);
      Eigen::Map<Eigen::MatrixXd> D(turn.own.data() + own, type.dim, type.dim);
      if (turn.anchor >= 0) turn.by_anchor.resize(by + type.dim * Pose::kDim);
      if (!is_pose(variables[k])) back.see(type, point, x, steps);
      if (is_pose(variables[k])) {
        const Pose step = back.from_point(point, x);
        Eigen::Map<typename Pose::Tangent>{steps} = step_over(step, has_points_);
        const Point back_to_point = Pose::load(point).rotation().inverse() * way;
        D = Pose(Point(step.translation() - back_to_point), step.rotation()).adjoint();
      } else if (type.kind != VariableKind::kVector) {
        D = local_jacobian(type, point, x);
      } else if (type.dim != kPointDim) {
        D.setIdentity();
      } else {
        const auto frame = back.motion.rotation().matrix();
        D = frame;
        if (turn.anchor >= 0) {
          Eigen::Map<Eigen::Matrix<double, kPointDim, Pose::kDim>> A(turn.by_anchor.data() + by);
          const Point step = Eigen::Map<const Point>(steps);
          const Pose held = Pose::load(values_.data(variables[turn.anchor]));
          A.setZero();
          A.template rightCols<kTurn>() = against_turn(step - way) * turn_of(back.motion * held);
        }
      }
      point += type.size;
      steps += type.dim;
    }
  }

  bool is_held(int variable) const override { return variables_.is_held(variable); }

  bool is_pose(int variable) const {
    return values_.type(variable).kind == Variable<Pose>::type().kind;
  }

  bool find_motion(const std::vector<int>& variables, int first, Chart chart, const double* steps,
                   const double* weights, MapMotion& motion) const override {
    const Pose before = motion_of(chart);
    const double* point = point_of(variables, first, chart);
    double most = 0.0;
    Pose best;
    Fit fit;
    for (std::size_t k = first; k < variables.size(); ++k) {
      const VariableType type = values_.type(variables[k]);
      const double* x = values_.data(variables[k]);
      const double weight = weights[k - first];
      if (is_pose(variables[k])) {
        if (weight > most) {
          const Pose seen = after_step(Pose::load(point), steps, has_points_);
          best = Pose::load(x) * (before * seen).inverse();
          most = weight;
        }
      } else if (most == 0.0 && is_point(type)) {
        const Point seen = Eigen::Map<const Point>(point) + Eigen::Map<const Point>(steps);
        fit.add(before * seen, Eigen::Map<const Point>(x));
      }
      point += type.size;
      steps += type.dim;
    }
    if (!(most > 0.0) && !fit.solve(best)) return false;
    best.normalize();
    motion[0] = 1.0;
    best.store(motion.data() + 1);
    return true;
  }

  void add(const MapMotion& motion, double* to) const override {
    Pose moved = Pose::load(motion.data() + 1) * motion_of({to, nullptr});
    moved.normalize();
    to[0] = 1.0;
    moved.store(to + 1);
  }

  void move(const std::vector<int>& variables, int count, const MapMotion& motion) override {
    const Pose by = Pose::load(motion.data() + 1);
    for (int k = 0; k < count; ++k) {
      variables_.before_change(variables[k]);
      double* x = estimate_->edit(variables[k]);
      move_with_map(by, values_.type(variables[k]), x);
    }
  }

  void place(const std::vector<int>& variables, int count, Chart chart,
             const double* steps) override {
    const Pose motion = motion_of(chart);
    const double* point = chart.points;
    for (int k = 0; k < count; ++k) {
      const VariableType type = values_.type(variables[k]);
      variables_.before_change(variables[k]);
      double* x = estimate_->edit(variables[k]);
      if (is_pose(variables[k])) {
        Pose pose = after_step(Pose::load(point), steps, has_points_);
        pose.normalize();
        pose.store(x);
      } else {
        retract(type, point, steps, x);
      }
      if (chart.is_moved()) move_with_map(motion, type, x);
      point += type.size;
      steps += type.dim;
    }
  }

 private:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;
  static constexpr int kTurn = Pose::kDim - kPointDim;
  using Rotation = Eigen::Matrix<double, kTurn, kTurn>;

  /// A turn in the tangent of a pose, as one about the axes that it is given in.
  static Rotation turn_of(const Pose& pose) {
    if constexpr (kTurn == 1) {
      return Rotation::Identity();
    } else {
      return pose.rotation().matrix();
    }
  }

  /// What an arrow changes by in a turn, taken back.
  static Eigen::Matrix<double, kPointDim, kTurn> against_turn(const Point& arrow) {
    Eigen::Matrix<double, kPointDim, kTurn> out;
    if constexpr (kTurn == 1) {
      out << arrow.y(), -arrow.x();
    } else {
      out << 0, -arrow.z(), arrow.y(), arrow.z(), 0, -arrow.x(), -arrow.y(), arrow.x(), 0;
    }
    return out;
  }

  /// How far the anchor has gone in the frame of the chart. Beside points a turn of the map is one
  /// about it: then its own step, and nearly those of all about it, depend on tangents at the
  /// estimates as steps along tangents do.
  Point turning_point(const std::vector<int>& variables, int anchor, Chart chart,
                      const Back<Pose>& back) const {
    if (!has_points_) return Point::Zero();
    const Pose now = back.motion * Pose::load(values_.data(variables[anchor]));
    return now.translation() - Pose::load(point_of(variables, anchor, chart)).translation();
  }

  /// The number of the first pose from `k` on, or that of all variables.
  int first_pose(const std::vector<int>& variables, int k) const {
    while (k < static_cast<int>(variables.size()) && !is_pose(variables[k])) ++k;
    return k;
  }

  static bool is_point(VariableType type) {
    return type.kind == VariableKind::kVector && type.dim == kPointDim;
  }

  /// The motion from some points to others in the least squares sense.
  class Fit {
   public:
    void add(const Point& from, const Point& to) {
      from_.push_back(from);
      to_.push_back(to);
    }
    bool solve(Pose& motion) const {
      if (static_cast<int>(from_.size()) < kPointDim) return false;
      using Many = Eigen::Matrix<double, kPointDim, Eigen::Dynamic>;
      Many a(kPointDim, from_.size()), b(kPointDim, from_.size());
      for (std::size_t k = 0; k < from_.size(); ++k) {
        a.col(k) = from_[k];
        b.col(k) = to_[k];
      }
      const auto T = Eigen::umeyama(a, b, false);
      if (!T.allFinite()) return false;
      const Point t = T.template topRightCorner<kPointDim, 1>();
      const Eigen::Matrix<double, kPointDim, kPointDim> R =
          T.template topLeftCorner<kPointDim, kPointDim>();
      if constexpr (kPointDim == 2) {
        motion = Pose(t, SO2(std::atan2(R(1, 0), R(0, 0))));
      } else {
        motion = Pose(t, Eigen::Quaterniond(R));
      }
      return true;
    }

   private:
    std::vector<Point> from_, to_;
  };

  static Pose motion_of(Chart chart) {
    return chart.is_moved() ? Pose::load(chart.motion + 1) : Pose();
  }

  const double* point_of(const std::vector<int>& variables, int i, Chart chart) const {
    const double* point = chart.points;
    for (int k = 0; k < i; ++k) point += values_.type(variables[k]).size;
    return point;
  }

  const Values& values_;
  JournaledValues* estimate_;
  const MapVariables& variables_;
  bool has_points_;
};

/// Assignments of the discrete variables of a factor that are looked at; with more it is one of the
/// map.
constexpr std::size_t kMostAssignments = 64;

}  // namespace

std::unique_ptr<Charts> make_charts(MapKind kind, const Values& values, JournaledValues* estimate,
                                    const MapVariables& variables) {
  if (kind.pose == VariableKind::kSE3)
    return std::make_unique<PoseCharts<SE3>>(values, estimate, variables, kind.has_points);
  return std::make_unique<PoseCharts<SE2>>(values, estimate, variables, kind.has_points);
}

namespace {

template <class Pose>
void steps_from(Chart chart, bool has_points, const std::vector<VariableType>& types,
                const double* const* x, double* steps) {
  const Back<Pose> back(chart, has_points);
  const double* point = chart.points;
  for (std::size_t i = 0; i < types.size(); ++i) {
    back.see(types[i], point, x[i], steps);
    point += types[i].size;
    steps += types[i].dim;
  }
}

}  // namespace

void steps_from(MapKind kind, Chart chart, const std::vector<VariableType>& types,
                const double* const* x, double* steps) {
  kind.pose == VariableKind::kSE3 ? steps_from<SE3>(chart, kind.has_points, types, x, steps)
                                  : steps_from<SE2>(chart, kind.has_points, types, x, steps);
}

bool moves_with_map(VariableKind pose, const ContinuousFactor& factor, const double* const* x) {
  const std::vector<VariableType>& types = factor.types();
  const int point_dim = pose == VariableKind::kSE3 ? 3 : 2;
  const auto is_moved = [&](VariableType type) {
    return type.kind == pose || (type.kind == VariableKind::kVector && type.dim == point_dim);
  };
  if (pose == VariableKind::kVector) return false;
  if (std::none_of(types.begin(), types.end(), is_moved)) return true;
  Eigen::VectorXd r(factor.rows());
  Eigen::MatrixXd J(factor.rows(), factor.cols());
  factor.linearize(x, r.data(), J.data());
  const std::vector<bool> has_place = located_variables(factor, x, J);
  int column = 0;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const bool counts = is_moved(types[i]) && !J.middleCols(column, types[i].dim).isZero(0.0);
    if (counts && !has_place[i]) return false;
    column += types[i].dim;
  }
  // Derivatives of zero, of a measurement that a robust loss has rejected, tell nothing.
  return std::any_of(has_place.begin(), has_place.end(), [](bool place) { return place; });
}

bool moves_with_map(VariableKind pose, const HybridFactor& factor, const double* const* x) {
  const std::size_t joint = joint_size(factor.discrete_keys());
  if (joint > kMostAssignments) return false;
  std::vector<int> known;
  std::vector<const double*> own;
  for (std::size_t i = 0; i < joint; ++i) {
    Assignment assignment;
    std::size_t rest = i;
    for (const DiscreteKey& key : factor.discrete_keys()) {
      assignment.set(key.key, static_cast<int>(rest % key.cardinality));
      rest /= key.cardinality;
    }
    const Component component = factor.given(assignment);
    if (component.factor == nullptr ||
        std::find(known.begin(), known.end(), component.index) != known.end())
      continue;
    known.push_back(component.index);
    own.clear();
    for (std::size_t k = 0; k < component.factor->keys().size(); ++k)
      own.push_back(x[component.positions != nullptr ? component.positions[k] : k]);
    if (!moves_with_map(pose, *component.factor, own.data())) return false;
  }
  return true;
}

}  // namespace hybrid
