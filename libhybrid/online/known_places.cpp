// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/online/known_places.h"

#include <algorithm>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {

template <class Pose>
Uncertain<Pose> relation_of(Key a, Key b, const IncrementalSmoother& smoother) {
  const Pose motion = smoother.values().at<Pose>(a).between(smoother.values().at<Pose>(b));
  Eigen::MatrixXd J(Pose::kDim, 2 * Pose::kDim);
  J << -motion.inverse().adjoint(), Pose::Jacobian::Identity();
  return {motion, smoother.joint_covariance({a, b}, J)};
}

template <class Pose>
std::vector<std::size_t> missing_places(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                        const std::function<bool(std::size_t place)>& is_held) {
  std::vector<std::size_t> out;
  for (std::size_t at = i; !is_held(at); at = places[at].parent->place) {
    out.push_back(at);
    if (!places[at].parent) break;
  }
  std::reverse(out.begin(), out.end());
  return out;
}

template <class Pose>
Uncertain<Pose> beside_parent(const std::vector<KnownPlace<Pose>>& places, std::size_t i) {
  const PlaceParent<Pose>& parent = *places[i].parent;
  return {places[parent.place].motion.between(places[i].motion), parent.covariance};
}

template <class Pose>
ContinuousFactorPtr factor_of_place(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                    const PlaceKeys& key) {
  const KnownPlace<Pose>& place = places[i];
  if (!place.parent) {
    return std::make_shared<Prior<Pose>>(key(i), place.motion, Noise::covariance(place.covariance));
  }
  const Uncertain<Pose> beside = beside_parent(places, i);
  return std::make_shared<Between<Pose>>(key(place.parent->place), key(i), beside.motion,
                                         Noise::covariance(beside.covariance));
}

template <class Pose>
Uncertain<Pose> relation_to_place(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                  Key pose, const IncrementalSmoother& smoother,
                                  const PlaceKeys& key) {
  const auto is_held = [&](std::size_t place) { return smoother.values().contains(key(place)); };
  const std::vector<std::size_t> missing = missing_places<Pose>(places, i, is_held);
  if (missing.empty()) return relation_of<Pose>(key(i), pose, smoother);
  const std::optional<PlaceParent<Pose>>& held = places[missing.front()].parent;
  if (!held) {
    const Pose here = smoother.values().at<Pose>(pose);
    return Uncertain<Pose>{Pose(), places[i].covariance} *
           Uncertain<Pose>{places[i].motion.between(here), smoother.joint_covariance({pose})};
  }
  Uncertain<Pose> way = beside_parent<Pose>(places, missing.front());
  for (std::size_t k = 1; k < missing.size(); ++k)
    way = way * beside_parent<Pose>(places, missing[k]);
  return inverse(way) * relation_of<Pose>(key(held->place), pose, smoother);
}

namespace {

template <class Pose>
void insert_missing(const std::vector<KnownPlace<Pose>>& places, std::size_t i, const Values& graph,
                    Delta& change) {
  const auto is_held = [&](std::size_t place) {
    return graph.contains(place_key(place)) || change.values.contains(place_key(place));
  };
  for (const std::size_t m : missing_places<Pose>(places, i, is_held)) {
    change.values.insert(place_key(m), places[m].motion);
    change.continuous.push_back(factor_of_place<Pose>(places, m));
  }
}

}  // namespace

void insert_place(const std::vector<KnownPlace<SE2>>& places, std::size_t i, const Values& graph,
                  Delta& change) {
  insert_missing(places, i, graph, change);
}

void insert_place(const std::vector<KnownPlace<SE3>>& places, std::size_t i, const Values& graph,
                  Delta& change) {
  insert_missing(places, i, graph, change);
}

template Uncertain<SE2> relation_of(Key, Key, const IncrementalSmoother&);
template std::vector<std::size_t> missing_places(const std::vector<KnownPlace<SE2>>&, std::size_t,
                                                 const std::function<bool(std::size_t)>&);
template Uncertain<SE2> beside_parent(const std::vector<KnownPlace<SE2>>&, std::size_t);
template ContinuousFactorPtr factor_of_place(const std::vector<KnownPlace<SE2>>&, std::size_t,
                                             const PlaceKeys&);
template Uncertain<SE2> relation_to_place(const std::vector<KnownPlace<SE2>>&, std::size_t, Key,
                                          const IncrementalSmoother&, const PlaceKeys&);
template Uncertain<SE3> relation_of(Key, Key, const IncrementalSmoother&);
template std::vector<std::size_t> missing_places(const std::vector<KnownPlace<SE3>>&, std::size_t,
                                                 const std::function<bool(std::size_t)>&);
template Uncertain<SE3> beside_parent(const std::vector<KnownPlace<SE3>>&, std::size_t);
template ContinuousFactorPtr factor_of_place(const std::vector<KnownPlace<SE3>>&, std::size_t,
                                             const PlaceKeys&);
template Uncertain<SE3> relation_to_place(const std::vector<KnownPlace<SE3>>&, std::size_t, Key,
                                          const IncrementalSmoother&, const PlaceKeys&);

}  // namespace hybrid
