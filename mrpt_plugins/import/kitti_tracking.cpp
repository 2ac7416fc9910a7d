// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/kitti_tracking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/camera.h"
#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

const char* const kClasses[] = {"Car",     "Van",  "Truck", "Pedestrian",
                                "Cyclist", "Tram", "Misc",  "Person_sitting"};
constexpr std::size_t kMinSightings = 3;
constexpr float kOwnScore = 0.9F;  // given to the class a detection has

struct Label {
  std::size_t frame;
  std::int64_t track;
  std::size_t class_index;
  Eigen::Vector3d point;  // in the frame of the robot
};

/// One object over time, in the world.
struct Track {
  std::vector<Eigen::Vector2d> places;
  std::size_t class_index = 0;

  Eigen::Vector2d mean() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& p : places) sum += p;
    return sum / static_cast<double>(places.size());
  }
  bool stands(double rms) const {
    if (places.size() < kMinSightings) return false;
    double sum = 0;
    const Eigen::Vector2d center = mean();
    for (const auto& p : places) sum += (p - center).squaredNorm();
    return sum <= rms * rms * static_cast<double>(places.size());
  }
};

std::vector<CPose3D> read_poses(const KittiTrackingOptions& options) {
  std::vector<CPose3D> poses;
  TextTable table(options.poses);
  while (const auto row = table.next()) {
    row->expect_columns(12, 12, "a 3x4 matrix");
    const CPose3D pose = flattened(robot_pose(*row, 0));
    poses.emplace_back(options.pose_scale * pose.x(), options.pose_scale * pose.y(), 0, pose.yaw(),
                       0, 0);
  }
  return poses;
}

std::vector<Label> read_labels(const KittiTrackingOptions& options, std::size_t frames,
                               LogWriter& log) {
  std::vector<Label> labels;
  TextTable table(options.labels);
  while (const auto row = table.next()) {
    row->expect_columns(17, 18,
                        "frame track class truncated occluded alpha box(4) size(3) X Y Z ry");
    if (row->words[2] == "DontCare") {
      log.drop("label dropped: DontCare");
      continue;
    }
    const auto* known = std::find(std::begin(kClasses), std::end(kClasses), row->words[2]);
    if (known == std::end(kClasses)) row->fail(fmt::format("unknown class '{}'", row->words[2]));
    Label label{static_cast<std::size_t>(row->id(0)), row->id(1),
                static_cast<std::size_t>(known - std::begin(kClasses)),
                robot_point({row->number(13), row->number(14), row->number(15)})};
    if (label.frame >= frames) row->fail(fmt::format("frame {} has no pose", label.frame));
    if (!labels.empty() && label.frame < labels.back().frame) row->fail("frames go backwards");
    if (label.point.x() <= 0) {
      log.drop("label dropped: behind the camera");
    } else if (label.point.head<2>().norm() > options.max_range) {
      log.drop("label dropped: too far away");
    } else {
      labels.push_back(label);
    }
  }
  return labels;
}

std::map<std::int64_t, Track> collect(const std::vector<Label>& labels,
                                      const std::vector<CPose3D>& poses) {
  std::map<std::int64_t, Track> tracks;
  for (const Label& label : labels) {
    Track& track = tracks[label.track];
    track.class_index = label.class_index;
    const auto p = poses[label.frame].composePoint({label.point.x(), label.point.y(), 0.0});
    track.places.emplace_back(p.x, p.y);
  }
  return tracks;
}

/// Scores of a detector that names the class right in a share of all cases.
std::vector<float> scores_of(std::size_t class_index, double accuracy, Random& random) {
  constexpr std::size_t kCount = std::size(kClasses);
  if (random.uniform() >= accuracy) {
    class_index = static_cast<std::size_t>(random.uniform() * static_cast<double>(kCount));
  }
  std::vector<float> scores(kCount, (1 - kOwnScore) / static_cast<float>(kCount - 1));
  scores[class_index] = kOwnScore;
  return scores;
}

}  // namespace

ImportReport import_kitti_tracking(const KittiTrackingOptions& options, const std::string& output) {
  LogWriter log(output);
  const std::vector<CPose3D> poses = read_poses(options);
  const std::vector<Label> labels = read_labels(options, poses.size(), log);
  const std::map<std::int64_t, Track> tracks = collect(labels, poses);
  Random random(options.noise.seed);
  auto label = labels.begin();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ImportedStep step;
    step.time = static_cast<double>(i) * options.period;
    step.truth = poses[i];
    if (i > 0) step.motion = noisy_motion(poses[i] - poses[i - 1], options.noise, false, random);
    auto frame = planar_detections("CAMERA", options.detector, CPose3D());
    frame->class_names.assign(std::begin(kClasses), std::end(kClasses));
    for (; label != labels.end() && label->frame == i; ++label) {
      auto d = detection_of(label->point, false);
      set_noise(options.detector, d);
      d.class_scores = scores_of(label->class_index, options.class_accuracy, random);
      if (tracks.at(label->track).stands(options.still_rms)) {
        d.landmark_id = static_cast<std::int32_t>(label->track);
      }
      frame->detections.push_back(d);
    }
    step.observations.push_back(frame);
    log.add(step);
  }
  for (const auto& [id, track] : tracks) {
    if (!track.stands(options.still_rms)) continue;
    const Eigen::Vector2d p = track.mean();
    log.true_landmark(id, {p.x(), p.y(), 0}, kClasses[track.class_index]);
  }
  return log.finish();
}

}  // namespace hybrid
