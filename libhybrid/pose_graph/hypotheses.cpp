// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <cmath>
#include <memory>
#include <random>
#include <type_traits>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

template <class Pose>
ContinuousFactorPtr make_factor(const GraphEdge<Pose>& edge, const Pose& z,
                                const GraphFactorOptions& options) {
  if constexpr (std::is_same_v<Pose, SE2>) {
    if (!options.planar_logarithm) {
      return std::make_shared<BetweenSE2>(edge.from, edge.to, z, edge.noise, options.loss);
    }
  }
  return std::make_shared<Between<Pose>>(edge.from, edge.to, z, edge.noise, options.loss);
}

template <class Pose>
HybridFactorPtr make_mixture(std::size_t index, const EdgeAlternatives<Pose>& alternatives,
                             const std::vector<GraphEdge<Pose>>& edges,
                             const GraphFactorOptions& options) {
  const GraphEdge<Pose>& edge = edges.at(alternatives.edge);
  std::vector<Pose> all = {edge.measured};
  all.insert(all.end(), alternatives.measured.begin(), alternatives.measured.end());
  std::vector<MixtureComponent> components;
  for (const Pose& z : all) {
    components.push_back(
        {make_factor(edge, z, options), std::log(static_cast<double>(all.size())), false});
  }
  return std::make_shared<Mixture>(
      std::vector<DiscreteKey>{{hypothesis_key(index), static_cast<int>(all.size())}},
      std::move(components));
}

template <class Pose>
void shuffle(std::vector<EdgeAlternatives<Pose>>& list, std::vector<GraphEdge<Pose>>& edges,
             std::mt19937_64& random, std::vector<int>& first) {
  for (EdgeAlternatives<Pose>& alternatives : list) {
    std::vector<std::pair<Pose, bool>> all = {{edges[alternatives.edge].measured, true}};
    for (const Pose& z : alternatives.measured) all.emplace_back(z, false);
    for (std::size_t i = all.size() - 1; i > 0; --i) std::swap(all[i], all[random() % (i + 1)]);
    edges[alternatives.edge].measured = all[0].first;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i > 0) alternatives.measured[i - 1] = all[i].first;
      if (all[i].second) first.push_back(static_cast<int>(i));
    }
  }
}

}  // namespace

HybridFactorPtr make_hypotheses(const PoseGraph& graph, std::size_t index,
                                const GraphFactorOptions& options) {
  const std::size_t planar = graph.alternatives2.size();
  if (index >= graph.alternatives_count()) {
    throw Error("the graph has no edge of hypotheses number " + std::to_string(index));
  }
  return index < planar
             ? make_mixture(index, graph.alternatives2[index], graph.poses2, options)
             : make_mixture(index, graph.alternatives3[index - planar], graph.poses3, options);
}

std::vector<int> shuffle_hypotheses(PoseGraph& graph, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<int> first;
  shuffle(graph.alternatives2, graph.poses2, random, first);
  shuffle(graph.alternatives3, graph.poses3, random, first);
  return first;
}

}  // namespace hybrid
