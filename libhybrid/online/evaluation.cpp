// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/online/detail/evaluation.h"

#include <algorithm>
#include <unordered_map>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/selection/evidence.h"

namespace hybrid {
namespace {

/// The variance factor, at most one, of the accepted closures.
double noise(const RobustProblem& problem, const Values& values,
             const std::vector<bool>& accepted) {
  std::vector<double> chi_squares;
  std::vector<int> rows;
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    if (!accepted[k]) continue;
    chi_squares.push_back(2.0 * problem.closures[k]->cost(values));
    rows.push_back(problem.closures[k]->rows());
  }
  return std::min(1.0, variance_factor(chi_squares, rows));
}

/// Places the variables of a map that a result does not know, from neighbour to neighbour.
template <class Pose>
class Extrapolation {
 public:
  Extrapolation(const Values& result, const IncrementalSmoother& smoother)
      : smoother_(smoother), values_(smoother.values()) {
    for (Key key : values_.keys()) {
      if (!result.contains(key)) {
        open_.push_back(key);
        continue;
      }
      const VariableType type = values_.type(key);
      if (type.kind == Variable<Pose>::type().kind) {
        motions_.emplace(key, result.at<Pose>(key) * values_.at<Pose>(key).inverse());
      }
      std::copy_n(result.data(key), type.size, values_.data(values_.slot(key)));
    }
  }

  Values run() {
    for (bool placed = true; placed && !open_.empty();) {
      const std::size_t before = open_.size();
      std::vector<Key> left;
      for (Key key : open_) {
        if (!place(key)) left.push_back(key);
      }
      open_ = std::move(left);
      placed = open_.size() < before;
    }
    return std::move(values_);
  }

 private:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;

  /// Moves a variable as the first pose that a measurement ties it to, if one has been placed.
  bool place(Key key) {
    for (Handle handle : smoother_.factors_of(key)) {
      if (handle.kind != FactorKind::kContinuous) continue;
      for (Key other : smoother_.graph().continuous().at(handle)->keys()) {
        const auto motion = motions_.find(other);
        if (motion == motions_.end()) continue;
        move(key, Pose(motion->second));
        return true;
      }
    }
    return false;
  }

  void move(Key key, const Pose& motion) {
    const VariableType type = values_.type(key);
    if (type.kind == Variable<Pose>::type().kind) {
      values_.update(key, motion * values_.at<Pose>(key));
      motions_.emplace(key, motion);
    } else if (type.kind == VariableKind::kVector && type.dim == kPointDim) {
      values_.update(key, Point(motion * values_.at<Point>(key)));
    }
  }

  const IncrementalSmoother& smoother_;
  Values values_;
  std::vector<Key> open_;
  std::unordered_map<Key, Pose> motions_;
};

}  // namespace

RobustResult evaluate_closures(const RobustProblem& problem, const std::vector<bool>& accepted,
                               const ClosureSelectionOptions& options) {
  RobustResult best = select_closures(problem, options);
  if (options.gate * noise(problem, problem.initial, accepted) <
      noise(problem, best.values, accepted_closures(best.decisions))) {
    ClosureSelectionOptions present = options;
    present.trust_start = true;
    best = select_closures(problem, present);
  }
  return best;
}

Values grown(const Values& result, const IncrementalSmoother& smoother) {
  for (Key key : result.keys()) {
    if (result.type(key).kind == VariableKind::kSE3)
      return Extrapolation<SE3>(result, smoother).run();
    if (result.type(key).kind == VariableKind::kSE2) break;
  }
  return Extrapolation<SE2>(result, smoother).run();
}

}  // namespace hybrid
