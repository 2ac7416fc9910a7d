// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/detail/graph.h"

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/point_match.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

Noise match_noise(const MatchWeights& weights, const Eigen::Vector3d& direction) {
  const Eigen::Matrix3d information = weights.all * Eigen::Matrix3d::Identity() +
                                      weights.directed * direction * direction.transpose();
  return Noise::information(information);
}

}  // namespace

HybridGraph registration_graph(const Points& source, const TargetCloud& target,
                               const MatchNoise& noise) {
  const MatchWeights weights(noise, target.shape());
  const int count = static_cast<int>(target.size());
  HybridGraph graph;
  for (std::size_t i = 0; i < source.size(); ++i) {
    std::vector<MixtureComponent> components;
    for (int k = 0; k < count; ++k) {
      components.push_back(
          {std::make_shared<PointMatch>(Key(key_letter::kPose, 0), source[i], target.point(k),
                                        match_noise(weights, target.direction(k)))});
    }
    const double normalizer = components.front().factor->log_normalizer();
    components.push_back({nullptr, 0.5 * noise.gate * noise.gate + normalizer});
    graph.add(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{{Key(key_letter::kCounterpart, i), count + 1}},
        std::move(components)));
  }
  return graph;
}

}  // namespace hybrid
