// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {

HybridFactorPtr make_hypotheses(const PoseGraph& graph, std::size_t index,
                                const GraphFactorOptions& options) {
  if (index >= graph.alternatives.size()) {
    throw Error("the graph has no edge of hypotheses number " + std::to_string(index));
  }
  const EdgeAlternatives& alternatives = graph.alternatives[index];
  const GraphEdge<SE2>& edge = graph.poses2.at(alternatives.edge);
  std::vector<SE2> all = {edge.measured};
  all.insert(all.end(), alternatives.measured.begin(), alternatives.measured.end());
  std::vector<MixtureComponent> components;
  for (const SE2& z : all) {
    ContinuousFactorPtr factor;
    if (options.planar_logarithm) {
      factor = std::make_shared<Between<SE2>>(edge.from, edge.to, z, edge.noise, options.loss);
    } else {
      factor = std::make_shared<BetweenSE2>(edge.from, edge.to, z, edge.noise, options.loss);
    }
    components.push_back({std::move(factor), std::log(static_cast<double>(all.size())), false});
  }
  return std::make_shared<Mixture>(
      std::vector<DiscreteKey>{{hypothesis_key(index), static_cast<int>(all.size())}},
      std::move(components));
}

std::vector<int> shuffle_hypotheses(PoseGraph& graph, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<int> first;
  for (EdgeAlternatives& alternatives : graph.alternatives) {
    std::vector<std::pair<SE2, bool>> all = {{graph.poses2[alternatives.edge].measured, true}};
    for (const SE2& z : alternatives.measured) all.emplace_back(z, false);
    for (std::size_t i = all.size() - 1; i > 0; --i) std::swap(all[i], all[random() % (i + 1)]);
    graph.poses2[alternatives.edge].measured = all[0].first;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i > 0) alternatives.measured[i - 1] = all[i].first;
      if (all[i].second) first.push_back(static_cast<int>(i));
    }
  }
  return first;
}

}  // namespace hybrid
