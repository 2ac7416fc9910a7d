// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A robot drives two rounds past trees and cars. Its sensor measures range, bearing and class
// scores, but no ids: the association is found together with the map.
#include <cmath>
#include <iostream>
#include <random>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/landmarks/landmark_mapper.h"

int main() {
  using namespace hybrid;
  const std::vector<std::string> names = {"tree", "car"};
  std::vector<Eigen::Vector2d> things;  // of class 0 and 1 alternately
  for (int k = 0; k < 10; ++k) {
    const double angle = 0.2 * M_PI * k + 0.1 * (k % 3), radius = k % 2 == 0 ? 12 : 8.5;
    things.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  std::mt19937 random(1);
  const auto noisy = [&](double sigma) {
    return sigma * std::normal_distribution<double>()(random);
  };
  const auto truth = [](int i) {
    return SE2(10 * std::cos(0.1 * i), 10 * std::sin(0.1 * i), 0.1 * i + M_PI / 2);
  };
  LandmarkMapper<SE2> mapper;
  for (int i = 0; i < 126; ++i) {
    DetectionFrame seen;
    seen.is_3d = false;
    seen.max_range = 8;
    seen.fov_yaw = 2 * M_PI;
    seen.class_names = names;
    for (std::size_t k = 0; k < things.size(); ++k) {
      const Eigen::Vector2d z = to_polar(Eigen::Vector2d(truth(i).inverse() * things[k]));
      if (z[0] > seen.max_range) continue;
      Detection detection;
      detection.range = z[0] + noisy(0.05);
      detection.yaw = z[1] + noisy(0.01);
      detection.covariance.diagonal() << 0.0025, 0.0001, 0;
      detection.class_probabilities = {k % 2 == 0 ? 0.8 : 0.2, k % 2 == 0 ? 0.2 : 0.8};
      seen.detections.push_back(detection);
    }
    // The map begins at the true start; then odometry drifts.
    const SE2 motion =
        i == 0 ? truth(0)
               : truth(i - 1).between(truth(i)) * SE2(noisy(0.03), noisy(0.03), noisy(0.006));
    const double sigma = i == 0 ? 1e-3 : 0.03;
    mapper.add(motion, Noise::diagonal(Eigen::Vector3d(sigma, sigma, 0.2 * sigma)), {seen});
  }
  mapper.finish();
  const Estimate map = mapper.smoother().estimate();
  std::size_t right = 0;
  for (const auto& [id, landmark] : mapper.landmarks()) {
    const Eigen::Vector2d p = map.values.at<Eigen::Vector2d>(landmark.position);
    const int kind = map.assignment.at(landmark.class_key->key);
    std::cout << names[kind] << " at " << p.transpose() << " m, seen " << landmark.sightings
              << " times\n";
    for (std::size_t k = kind; k < things.size(); k += 2) right += (p - things[k]).norm() < 0.5;
  }
  return right == things.size() && mapper.landmarks().size() == things.size() ? 0 : 1;
}
