// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/same_motion.h"

namespace hybrid {
namespace {

constexpr std::size_t kFewestStretches = 10;  // of the longest kind, one after the other
constexpr double kUnexplained = 0.5;          // of the variance of the odometry
constexpr double kDrift = 0.25;               // of the way, more than any odometry's

/// Squared sums over the stretches of one length.
struct Agreement {
  double motion = 0;      ///< of the odometry
  double about_mean = 0;  ///< of the odometry less its mean
  double difference = 0;  ///< of odometry and truth
};

/// What is known of the motion from pose a to pose b, in the frame of a.
Eigen::Vector3d motion(const mrpt::poses::CPose3D& a, const mrpt::poses::CPose3D& b,
                       TruthContent content) {
  const mrpt::poses::CPose3D step = b - a;
  if (content == TruthContent::kPositions) return {step.norm(), 0, 0};
  return {step.x(), step.y(), step.z()};
}

Agreement agreement(const std::vector<PosePair>& pairs, std::size_t length, TruthContent content) {
  Agreement out;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (std::size_t i = 0; i + length < pairs.size(); i += length) {
    const PosePair &a = pairs[i], &b = pairs[i + length];
    const Eigen::Vector3d told = motion(a.estimate, b.estimate, content);
    sum += told;
    ++count;
    out.motion += told.squaredNorm();
    out.difference += (told - motion(a.truth, b.truth, content)).squaredNorm();
  }
  out.about_mean = out.motion - sum.squaredNorm() / static_cast<double>(count);
  return out;
}

}  // namespace

bool may_be_same_motion(const std::vector<PosePair>& reckoned, TruthContent content) {
  if (reckoned.size() < 4 * kFewestStretches) return true;
  Agreement longest;
  for (std::size_t length = 1; length * kFewestStretches < reckoned.size(); length *= 2) {
    longest = agreement(reckoned, length, content);
    if (longest.difference < kUnexplained * longest.about_mean) return true;
  }
  return longest.difference <= kDrift * kDrift * longest.motion;
}

}  // namespace hybrid
