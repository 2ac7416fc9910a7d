// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/input/ground_truth.h"
#include "mrpt_plugins/output/landmark_metrics.h"

namespace hybrid {
namespace {

constexpr double kMaxTimeDifference = 0.05;  // s, between a pose and its truth in a TUM file

}  // namespace

Truth::Truth(const std::string& path_file, const std::string& map_file)
    : path_file_(path_file), map_file_(map_file) {
  if (!path_file.empty()) {
    has_times_ = std::filesystem::path(path_file).extension() == ".tum";
    if (has_times_) {
      truth_.path = read_tum(path_file);
    } else {
      for (const auto& pose : read_true_path(path_file)) {
        truth_.path.push_back({static_cast<double>(truth_.path.size()), pose});
      }
    }
  }
  if (map_file.empty()) return;
  for (LandmarkTruth& row : read_true_landmarks(map_file)) {
    truth_.landmarks.push_back({row.id, row.position, std::nullopt});
    landmark_classes_.push_back(std::move(row.class_name));
  }
}

void Truth::adapt_to(const MapResult& result, const std::vector<std::size_t>& log_rows) {
  const std::vector<std::string>& names = result.class_names;
  for (std::size_t i = 0; i < landmark_classes_.size() && !names.empty(); ++i) {
    if (landmark_classes_[i].empty()) continue;
    const auto it = std::find(names.begin(), names.end(), landmark_classes_[i]);
    if (it == names.end()) {
      throw Error(fmt::format("{}: landmark {} is of class '{}', which the log does not know",
                              map_file_, truth_.landmarks[i].id, landmark_classes_[i]));
    }
    truth_.landmarks[i].class_index = static_cast<int>(it - names.begin());
  }
  if (truth_.path.empty() || result.trajectory.empty()) return;
  const std::vector<PosePair> first = pairs({result.trajectory.front()}, {log_rows.front()});
  if (first.empty()) {
    throw Error(fmt::format("{}: has no pose within {} s of the first pose of the log", path_file_,
                            kMaxTimeDifference));
  }
  const mrpt::poses::CPose3D origin = first.front().truth;
  for (TimedPose& pose : truth_.path) pose.pose = pose.pose - origin;
  for (TrueLandmark& landmark : truth_.landmarks) {
    const auto p = origin.inverseComposePoint(
        {landmark.position.x(), landmark.position.y(), landmark.position.z()});
    landmark.position = {p.x, p.y, p.z};
  }
}

std::vector<PosePair> Truth::pairs(const Trajectory& estimate,
                                   const std::vector<std::size_t>& log_rows) const {
  if (has_times_) return pair_by_time(estimate, truth_.path, kMaxTimeDifference);
  const std::size_t last = *std::max_element(log_rows.begin(), log_rows.end());
  if (last >= truth_.path.size()) {
    throw Error(fmt::format("{}: has {} poses, but the log has a frame for row {}", path_file_,
                            truth_.path.size(), last));
  }
  return pair_by_index(estimate, truth_.path, log_rows);
}

TruthSummary compare(const Truth& truth, const MapResult& result, const Mapper& mapper) {
  TruthSummary summary;
  if (!truth.get().path.empty()) {
    const auto pairs = truth.pairs(result.trajectory, mapper.log_rows());
    summary.trajectory = trajectory_report(pairs);
    summary.dead_reckoning =
        trajectory_report(truth.pairs(result.dead_reckoning, mapper.log_rows()));
    const auto covariances = mapper.pose_covariances();
    const bool complete = std::all_of(covariances.begin(), covariances.end(),
                                      [](const auto& P) { return P.rows() > 0; });
    if (complete && pairs.size() == covariances.size()) {
      summary.nees_pose = mean_nees(pairs, covariances);
    }
  }
  if (!truth.get().landmarks.empty()) {
    const auto matching = match_by_id(result.landmarks, truth.get().landmarks);
    summary.landmarks = landmark_errors(matching, result.landmarks, truth.get().landmarks);
    summary.class_accuracy = class_accuracy(matching, result.landmarks, truth.get().landmarks);
  }
  return summary;
}

}  // namespace hybrid
