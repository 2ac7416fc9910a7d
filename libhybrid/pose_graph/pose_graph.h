// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/loss.h"
#include "libhybrid/core/noise.h"
#include "libhybrid/core/values.h"
#include "libhybrid/factors/relative_pose.h"
#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// A measurement of `to` in the frame of `from`: a relative pose, or the position of a landmark.
/// The noise is over its tangent (translation [m], rotation [rad]).
template <class T>
struct GraphEdge {
  Key from;
  Key to;
  T measured;
  Noise noise;
};

/// Appends the relative pose that the factor measures; false if it measures none.
template <class Pose>
bool add_relative_pose(const ContinuousFactor& factor, std::vector<GraphEdge<Pose>>& edges) {
  const auto motion = relative_pose<Pose>(factor);
  if (!motion) return false;
  edges.push_back({factor.keys()[0], factor.keys()[1], motion->measured,
                   Noise::information(motion->information)});
  return true;
}

/// Further hypotheses for the measurement of an edge; one of all its hypotheses is true.
template <class Pose>
struct EdgeAlternatives {
  std::size_t edge = 0;  ///< in poses2 or poses3 of the graph, whose measurement is hypothesis 0
  std::vector<Pose> measured;
};

/// A pose measured in the frame of the map.
template <class Pose>
struct GraphPrior {
  Key pose;
  Pose measured;
  Noise noise;
};

/// A position [m] measured in the frame of the map, of the point at `lever_arm` [m] on a pose.
template <class Point>
struct GraphPosition {
  Key pose;
  Point measured;
  Noise noise;
  Point lever_arm = Point::Zero();
};

/// The contents of a g2o or TORO file: all in the plane, or all in space. Poses are Key{'x', id},
/// landmarks Key{'l', id}; vertex_index has the index of ids beyond 55 bits.
struct PoseGraph {
  Values values;  ///< of VERTEX lines, which may be missing
  std::vector<GraphEdge<SE2>> poses2;
  std::vector<GraphEdge<SE3>> poses3;
  std::vector<GraphEdge<Eigen::Vector2d>> points2;
  std::vector<GraphEdge<Eigen::Vector3d>> points3;
  std::vector<GraphPrior<SE2>> priors2;
  std::vector<GraphPrior<SE3>> priors3;
  std::vector<GraphPosition<Eigen::Vector2d>> positions2;
  std::vector<GraphPosition<Eigen::Vector3d>> positions3;
  std::vector<EdgeAlternatives<SE2>> alternatives2;  ///< in order of their edges
  std::vector<EdgeAlternatives<SE3>> alternatives3;
  std::vector<Key> fixed;
  std::size_t equivalences = 0;  ///< EQUIV lines, which are not applied
  std::size_t repaired = 0;      ///< information matrices of the file that were projected
  std::size_t unseen = 0;        ///< landmarks of the file that nothing measures, left out
  std::size_t copies = 0;        ///< edges that erase_copies has left out
  bool edge2_by_rows = false;    ///< information of EDGE2 was taken row by row

  std::size_t edge_count() const {
    return poses2.size() + poses3.size() + points2.size() + points3.size();
  }
  /// Measurements in the frame of the map.
  std::size_t prior_count() const {
    return priors2.size() + priors3.size() + positions2.size() + positions3.size();
  }
  std::size_t alternatives_count() const { return alternatives2.size() + alternatives3.size(); }
};

/// Whether the ids of two poses follow each other, in either direction: then a relative pose is
/// odometry, or else a loop closure. OdometryEdges tells it in a graph whose ids skip numbers.
inline bool is_odometry(Key from, Key to) {
  return to.index() == from.index() + 1 || from.index() == to.index() + 1;
}

/// Tells odometry from loop closures: an edge is odometry if its poses follow each other in the
/// order of their ids, in either direction. Ids may skip numbers, but not from one character of
/// GTSAM's symbols (a robot) to the next.
class OdometryEdges {
 public:
  explicit OdometryEdges(const PoseGraph& graph);

  bool operator()(Key from, Key to) const;

 private:
  std::unordered_map<Key, Key> next_;  // of each pose behind which numbers are skipped
};

/// Values of all poses from relative motions alone: odometry edges (between successive poses, the
/// first of each) as far as they reach, then other edges; landmarks from their first sighting. The
/// pose of smallest id has its VERTEX value, or else is at the origin; then all is moved to the
/// map, see move_to_map. Parts that no edge connects are placed one by one if each is measured in
/// the map. Throws Error naming vertices that neither connects to it.
Values initialize_from_odometry(const PoseGraph& graph);

/// The same along the tree of shortest paths from that pose, where the length of an edge is the
/// variance of its rotation [rad^2] (the trace, for rotations in space): of all initial values from
/// chained relative motions these have the least variance of rotation, which decides whether
/// solvers converge.
Values initialize_from_tree(const PoseGraph& graph);

/// Moves values rigidly to where the graph measures the map: by the first fixed pose that has a
/// VERTEX value, which no measurement is as sure as, or by the first pose measured in the map, or
/// by its positions if there are at least two in the plane or three in space. Otherwise they stay,
/// and false is returned. Values may be those of a part of the graph.
bool move_to_map(const PoseGraph& graph, Values& values);

/// Leaves out landmarks that nothing measures and that are not fixed; returns their number.
std::size_t erase_unseen_landmarks(PoseGraph& graph);

/// Leaves out edges that are the same as one before, to the last bit: measurements that came twice,
/// not two that agree, which would be evidence for each other. Counts them in the graph. A graph
/// with alternatives stays as it is.
void erase_copies(PoseGraph& graph);

/// Whether the information of most relative poses says less than nothing, and its inverse would
/// not: standard deviations of more than half a turn, and of more than the measured way. Then it is
/// likely a covariance.
bool is_information_inverted(const PoseGraph& graph);

/// Options of the factors made of edges.
struct GraphFactorOptions {
  /// Whether the residual of planar edges is the group logarithm (Between<SE2>), or the angle and
  /// the translation in the measured frame (BetweenSE2), which converges from far worse initial
  /// values.
  bool planar_logarithm = false;
  Loss loss;
  /// Standard deviation [m, rad] of the priors on fixed vertices.
  double anchor_sigma = 1e-3;
};

/// The factors of a graph: one per edge (relative poses in order of the file, then sightings of
/// landmarks), then one per measurement in the frame of the map, then a prior on each fixed vertex,
/// or on the pose of smallest id if nothing is fixed and no pose or position measured in the map.
/// A fixed vertex is at its VERTEX value, or without one at its `initial` value.
std::vector<ContinuousFactorPtr> to_factors(const PoseGraph& graph, const Values& initial,
                                            const GraphFactorOptions& options = {});

/// The mixture over the hypotheses of an edge (eq. 3), with equal prior probabilities; the discrete
/// variable hypothesis_key(index) chooses. Edges are numbered through alternatives2, then
/// alternatives3. Throws Error for an index that is out of range.
HybridFactorPtr make_hypotheses(const PoseGraph& graph, std::size_t index,
                                const GraphFactorOptions& options = {});
inline Key hypothesis_key(std::size_t index) {
  return Key(key_letter::kHypothesis, index);
}

/// Puts the hypotheses of every edge in a random order, the same for the same seed on every
/// machine. Returns, for each of these edges, the new index of the hypothesis that was first.
std::vector<int> shuffle_hypotheses(PoseGraph& graph, std::uint64_t seed);

/// The part of an estimated graph that a g2o file can hold: poses x<id> and landmarks l<id> with
/// their estimates, the pose of smallest id fixed; relative poses and sightings of landmarks, of
/// the continuous factors and of the components chosen by the assignment unless weak. A
/// bearing-range measurement becomes a position in the robot frame, its covariance to first order.
/// All other factors are left out.
PoseGraph to_pose_graph(const HybridGraph& graph, const Estimate& estimate);

}  // namespace hybrid
