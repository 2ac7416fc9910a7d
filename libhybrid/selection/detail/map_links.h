// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/core/error.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/selection/evidence.h"

namespace hybrid {

/// Poses and positions measured in the frame of the map that tell where a part of a trajectory
/// lies.
struct MapLinks {
  std::vector<std::size_t> closures;  ///< of the problem; empty if none tell it
  std::size_t agreeing = 0;           ///< others that agree with these
  bool decided = false;               ///< by the evidence of those that agree
  Values values;                      ///< the part where it lies
};

/// Choices that are tried: until a better one is this improbable, by the share of the closures that
/// agree, and within this budget of time, in variables of all choices.
inline constexpr double kMissedChoice = 1e-3;
inline constexpr std::size_t kFewestChoices = 8, kMostChoices = 64, kMostVariables = 100000;
/// Positions of a choice are at least this part of the largest distance apart.
inline constexpr double kFarApart = 0.5;
inline constexpr double kOnePlace = 1e-3;  // [m]

/// A measurement of the map, and where the part itself has what it measures.
struct Absolute {
  std::size_t closure = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

template <class Pose>
std::vector<GraphPrior<Pose>>& poses_in(PoseGraph& graph) {
  if constexpr (Pose::kDim == 3) {
    return graph.priors2;
  } else {
    return graph.priors3;
  }
}

template <class Pose>
std::vector<GraphPosition<typename Pose::Point>>& positions_in(PoseGraph& graph) {
  if constexpr (Pose::kDim == 3) {
    return graph.positions2;
  } else {
    return graph.positions3;
  }
}

/// Adds to a graph what a factor measures of the map.
template <class Pose>
void add_absolute(const ContinuousFactor& factor, PoseGraph& graph) {
  if (const auto* pose = dynamic_cast<const Prior<Pose>*>(&factor)) {
    poses_in<Pose>(graph).push_back({pose->keys()[0], pose->measured(), Noise::unit(Pose::kDim)});
  } else if (const auto* position = dynamic_cast<const Position<Pose>*>(&factor)) {
    positions_in<Pose>(graph).push_back({position->keys()[0], position->measured(),
                                         Noise::unit(factor.rows()), position->lever_arm()});
  }
}

template <class Pose>
class MapChoices {
 public:
  MapChoices(const RobustProblem& part, const ClosureSelectionOptions& options)
      : part_(part), options_(options) {
    for (std::size_t k = 0; k < part.closures.size(); ++k) {
      const ContinuousFactor& factor = *part.closures[k];
      if (dynamic_cast<const Prior<Pose>*>(&factor) != nullptr) {
        poses_.push_back({k});
      } else if (const auto* position = dynamic_cast<const Position<Pose>*>(&factor)) {
        const typename Pose::Point at =
            part.initial.at<Pose>(factor.keys()[0]) * position->lever_arm();
        positions_.push_back({k});
        positions_.back().point.template head<kPoint>() = at;
      }
    }
  }

  MapLinks best() {
    for (std::size_t i = 0; i < poses_.size() && open(i, 1); ++i) {
      try_choice({poses_[(i * kStride) % poses_.size()].closure});
    }
    for (std::size_t i = 0; positions_.size() >= kPoint && open(i, kPoint); ++i) {
      const std::vector<std::size_t> choice = choose_positions();
      if (choice.size() == kPoint) try_choice(choice);
    }
    return std::move(best_);
  }

 private:
  static constexpr int kPoint = Pose::Point::RowsAtCompileTime;
  /// A prime, so that poses follow each other that are far apart: false ones may be neighbours.
  static constexpr std::size_t kStride = 2147483647;

  /// Whether another choice of so many measurements may be better, after `tried` ones.
  bool open(std::size_t tried, int size) const {
    const std::size_t budget =
        std::clamp(kMostVariables / (1 + part_.initial.size()), kFewestChoices, kMostChoices);
    if (tried >= budget) return false;
    const double share =
        double(best_.closures.size() + best_.agreeing) / double(poses_.size() + positions_.size());
    return double(tried) * std::log1p(-std::min(0.999, std::pow(share, size))) >
           std::log(kMissedChoice);
  }

  std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }

  /// Positions far from each other, at random; fewer if there are none.
  std::vector<std::size_t> choose_positions() {
    std::vector<std::size_t> choice;
    std::vector<Eigen::Vector3d> points;
    while (points.size() < kPoint) {
      std::vector<double> distance;
      for (const Absolute& at : positions_) distance.push_back(distance_from(points, at.point));
      const double far = kFarApart * *std::max_element(distance.begin(), distance.end());
      if (!points.empty() && far < kOnePlace) return {};
      std::vector<std::size_t> candidates;
      for (std::size_t k = 0; k < distance.size(); ++k) {
        if (distance[k] >= far) candidates.push_back(k);
      }
      const Absolute& next = positions_[candidates[below(candidates.size())]];
      choice.push_back(next.closure);
      points.push_back(next.point);
    }
    return choice;
  }

  /// From no point, one, or the line through two.
  static double distance_from(const std::vector<Eigen::Vector3d>& points,
                              const Eigen::Vector3d& point) {
    if (points.empty()) return 0.0;
    const Eigen::Vector3d way = point - points[0];
    return points.size() == 1 ? way.norm() : (points[1] - points[0]).normalized().cross(way).norm();
  }

  void try_choice(const std::vector<std::size_t>& choice) {
    RobustProblem held = part_;
    held.closures.clear();
    PoseGraph graph;
    std::vector<bool> chosen(part_.closures.size(), false);
    for (const std::size_t k : choice) chosen[k] = true;
    for (std::size_t k = 0; k < chosen.size(); ++k) {
      (chosen[k] ? held.trusted : held.closures).push_back(part_.closures[k]);
      if (chosen[k]) add_absolute<Pose>(*part_.closures[k], graph);
    }
    if (!move_to_map(graph, held.initial)) return;
    RobustResult result;
    try {
      result = select_closures(held, options_);
    } catch (const Error&) {
      return;  // it holds the part badly
    }
    if (!best_.closures.empty() && !(result.objective < objective_)) return;
    objective_ = result.objective;
    best_ = {choice, 0, false, std::move(result.values)};
    note_agreement(result.decisions);
  }

  void note_agreement(const std::vector<ClosureDecision>& decisions) {
    const double chance = std::log1p(static_cast<double>(decisions.size()));
    double excess = 0.0;
    for (const ClosureDecision& decision : decisions) {
      if (!decision.accepted()) continue;
      ++best_.agreeing;
      excess += std::max(0.0, decision.evidence - chance);
    }
    best_.decided = excess > evidence_needed(decisions.size(), options_);
  }

  const RobustProblem& part_;
  const ClosureSelectionOptions& options_;
  std::vector<Absolute> poses_, positions_;
  std::mt19937_64 random_;
  MapLinks best_;
  double objective_ = 0.0;
};

/// Chooses among the closures of a part, which are poses and positions that may be false, as few as
/// hold it where most others agree: one pose, two positions in the plane or three in space. Each
/// choice that is tried is trusted, and select_closures tells with what objective the others fit.
/// The trusted factors connect the part, and hold it nowhere.
inline MapLinks find_map_links(const RobustProblem& part, const ClosureSelectionOptions& options) {
  for (const Key key : part.initial.keys()) {
    if (part.initial.type(key) == Variable<SE2>::type()) {
      return MapChoices<SE2>(part, options).best();
    }
  }
  return MapChoices<SE3>(part, options).best();
}

}  // namespace hybrid
