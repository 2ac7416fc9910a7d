// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/online/join_graph.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/online/closure_graph.h"

namespace hybrid {
namespace {

/// Smallest standard deviation of a place, such as of one that defines the frame [m, rad].
constexpr double kLeastOfPlace = 1e-4;

/// Of the frame of the second map in that of the first.
const Key kMotionKey(key_letter::kPose, 0);

Key key_of_first(std::size_t i) {
  return {key_letter::kPose, (std::size_t{1} << 30) + i};
}

Key key_of_second(std::size_t k) {
  return {key_letter::kPose, k + 1};
}

/// The anchors of places, none of which is known better than anything is.
template <class Pose>
std::vector<KnownPlace<Pose>> anchors_of(const std::vector<StoredPlace<Pose>>& places) {
  const auto least = kLeastOfPlace * kLeastOfPlace * Pose::Jacobian::Identity();
  std::vector<KnownPlace<Pose>> out;
  for (const StoredPlace<Pose>& place : places) {
    KnownPlace<Pose>& anchor = out.emplace_back(place.T_map_anchor);
    anchor.covariance += least;
    if (anchor.parent) anchor.parent->covariance += least;
  }
  return out;
}

}  // namespace

template <class Pose>
typename Pose::Point nearest_anchor(const std::vector<StoredPlace<Pose>>& first,
                                    const std::vector<StoredPlace<Pose>>& second,
                                    const Pose& T_first_second) {
  double least = std::numeric_limits<double>::infinity();
  typename Pose::Point nearest = Pose::Point::Zero();
  for (const StoredPlace<Pose>& a : first) {
    for (const StoredPlace<Pose>& b : second) {
      const typename Pose::Point& at = b.T_map_anchor.motion.translation();
      const double distance = (T_first_second * at - a.T_map_anchor.motion.translation()).norm();
      if (distance >= least) continue;
      least = distance;
      nearest = at;
    }
  }
  return nearest;
}

template Eigen::Vector2d nearest_anchor(const std::vector<StoredPlace<SE2>>&,
                                        const std::vector<StoredPlace<SE2>>&, const SE2&);
template Eigen::Vector3d nearest_anchor(const std::vector<StoredPlace<SE3>>&,
                                        const std::vector<StoredPlace<SE3>>&, const SE3&);

template <class Pose>
JoinGraph<Pose>::JoinGraph(std::vector<StoredPlace<Pose>> first,
                           std::vector<StoredPlace<Pose>> second, const Uncertain<Pose>& motion,
                           const typename Pose::Point& where, const Match& match,
                           const Options& options)
    : first_(std::move(first)),
      second_(std::move(second)),
      first_anchors_(anchors_of(first_)),
      second_anchors_(anchors_of(second_)) {
  insert(kMotionKey, motion.motion,
         std::make_shared<Prior<Pose>>(kMotionKey, motion.motion,
                                       Noise::covariance(motion.covariance)));
  std::vector<std::size_t> order(second_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto distance = [&](std::size_t k) {
    return (second_[k].T_map_anchor.motion.translation() - where).norm();
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
  for (const std::size_t k : order) add(k, match, options);
  selection_.finish();
}

template <class Pose>
void JoinGraph<Pose>::insert(Key key, const Pose& pose, ContinuousFactorPtr factor) {
  Delta delta;
  delta.values.insert(key, pose);
  delta.continuous.push_back(std::move(factor));
  selection_.update(delta);
}

template <class Pose>
Uncertain<Pose> JoinGraph<Pose>::estimate(Key key) const {
  return {
      selection_.smoother().values().template at<Pose>(key),
      selection_.smoother().joint_covariance({key}, Eigen::MatrixXd(Pose::Jacobian::Identity()))};
}

/// Places of the first map that may show what one of the second saw, the nearest ones.
template <class Pose>
std::vector<std::size_t> JoinGraph<Pose>::near(std::size_t k, const Options& options) const {
  const Pose here = selection_.smoother().values().template at<Pose>(key_of_second(k));
  const typename Pose::Point middle = here * second_[k].middle;
  std::vector<std::pair<double, std::size_t>> all;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    if (first_[i].is_empty) continue;
    const double distance = (first_[i].T_map_anchor.motion * first_[i].middle - middle).norm();
    if (distance < options.view) all.emplace_back(distance, i);
  }
  std::sort(all.begin(), all.end());
  std::vector<std::size_t> out;
  for (const auto& [distance, i] : all) {
    if (static_cast<int>(out.size()) < options.most_maps) out.push_back(i);
  }
  return out;
}

/// Where a place of the second map is in one of the first, as known so far.
template <class Pose>
Uncertain<Pose> JoinGraph<Pose>::relation(std::size_t i, std::size_t k) const {
  return relation_to_place<Pose>(first_anchors_, i, key_of_second(k), selection_.smoother(),
                                 key_of_first);
}

/// Adds a place of the first map, and those beside which it is known.
template <class Pose>
void JoinGraph<Pose>::insert_first(std::size_t i) {
  const auto is_held = [&](std::size_t place) { return holds(key_of_first(place)); };
  for (const std::size_t m : missing_places<Pose>(first_anchors_, i, is_held)) {
    insert(key_of_first(m), first_anchors_[m].motion,
           factor_of_place<Pose>(first_anchors_, m, key_of_first));
  }
}

/// The same of the second map; what is known beside no other is so in the frame of that map.
template <class Pose>
void JoinGraph<Pose>::insert_second(std::size_t k) {
  const auto is_held = [&](std::size_t place) { return holds(key_of_second(place)); };
  for (const std::size_t m : missing_places<Pose>(second_anchors_, k, is_held)) {
    const KnownPlace<Pose>& place = second_anchors_[m];
    const Pose motion = selection_.smoother().values().template at<Pose>(kMotionKey);
    insert(key_of_second(m), motion * place.motion,
           place.parent
               ? factor_of_place<Pose>(second_anchors_, m, key_of_second)
               : std::make_shared<Between<Pose>>(kMotionKey, key_of_second(m), place.motion,
                                                 Noise::covariance(place.covariance)));
  }
}

/// Adds a place of the second map, and its matches.
template <class Pose>
void JoinGraph<Pose>::add(std::size_t k, const Match& match, const Options& options) {
  const Key key = key_of_second(k);
  insert_second(k);
  if (second_[k].is_empty) return;
  std::vector<ContinuousFactorPtr> found;
  Alternatives modes;
  for (const std::size_t i : near(k, options)) {
    const std::size_t first_mode = found.size();
    for (const Uncertain<Pose>& mode : match(i, k, relation(i, k))) {
      insert_first(i);
      modes.add(first_mode);
      matches_.push_back({i, k, mode});
      found.push_back(std::make_shared<Between<Pose>>(key_of_first(i), key, mode.motion,
                                                      Noise::covariance(mode.covariance)));
    }
  }
  if (!found.empty()) selection_.update({}, found, modes);
}

template <class Pose>
std::vector<PlaceMatch<Pose>> JoinGraph<Pose>::accepted() const {
  std::vector<PlaceMatch<Pose>> out;
  for (std::size_t c = 0; c < matches_.size(); ++c) {
    if (selection_.status(c) == ClosureStatus::kAccepted) out.push_back(matches_[c]);
  }
  return out;
}

template <class Pose>
Uncertain<Pose> JoinGraph<Pose>::motion() const {
  return estimate(kMotionKey);
}

template <class Pose>
std::vector<KnownPlace<Pose>> JoinGraph<Pose>::anchors() const {
  std::vector<KnownPlace<Pose>> out;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    out.push_back(first_[i].T_map_anchor);
    if (!holds(key_of_first(i))) continue;
    static_cast<Uncertain<Pose>&>(out.back()) = estimate(key_of_first(i));
  }
  const std::vector<PlaceMatch<Pose>> right = accepted();
  for (std::size_t k = 0; k < second_.size(); ++k) {
    KnownPlace<Pose>& anchor = out.emplace_back(estimate(key_of_second(k)));
    anchor.parent = second_[k].T_map_anchor.parent;
    if (anchor.parent) {
      anchor.parent->place += first_.size();
    } else if (!right.empty()) {
      const std::size_t beside = right.front().first;
      anchor.parent = {
          beside, relation_of<Pose>(key_of_first(beside), key_of_second(k), selection_.smoother())
                      .covariance};
    }
  }
  return out;
}

template class JoinGraph<SE2>;
template class JoinGraph<SE3>;

}  // namespace hybrid
