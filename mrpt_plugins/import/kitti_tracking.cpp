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
constexpr double kMinSightings = 3;
constexpr float kOwnScore = 0.9F;  // given to the class a detection has

struct Label {
  std::int64_t track;
  std::size_t class_index;
  Eigen::Vector3d point;  // in the frame of the robot
};

/// One object over time, in the world.
struct Track {
  double count = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();  // squares are taken from there
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  std::size_t class_index = 0;

  void add(const Eigen::Vector2d& place) {
    if (count == 0) first = place;
    ++count;
    sum += place - first;
    squares += (place - first).squaredNorm();
  }
  Eigen::Vector2d mean() const { return first + sum / count; }
  bool stands(double rms) const {
    return count >= kMinSightings && squares - sum.squaredNorm() / count <= rms * rms * count;
  }
};

/// Streams the poses of the robot.
class Poses {
 public:
  explicit Poses(const KittiTrackingOptions& options)
      : scale_(options.pose_scale), table_(options.poses) {}

  std::optional<CPose3D> next() {
    const auto row = table_.next();
    if (!row) return std::nullopt;
    row->expect_columns(12, 12, "a 3x4 matrix");
    const CPose3D pose = flattened(robot_pose(*row, 0));
    return CPose3D(scale_ * pose.x(), scale_ * pose.y(), 0, pose.yaw(), 0, 0);
  }

 private:
  double scale_;
  TextTable table_;
};

/// Streams the labels that are used; the others are counted.
class Labels {
 public:
  Labels(const KittiTrackingOptions& options, DropReport& dropped)
      : max_range_(options.max_range), dropped_(dropped), table_(options.labels) {
    advance();
  }

  /// Those of a frame, which come one after the other.
  std::vector<Label> of(std::size_t frame) {
    std::vector<Label> out;
    for (; row_ && static_cast<std::size_t>(row_->id(0)) == frame; advance()) {
      if (auto label = read()) out.push_back(*label);
    }
    return out;
  }

  /// Throws Error if there are labels of frames after the last one asked for.
  void finish() const {
    if (row_) row_->fail(fmt::format("frame {} has no pose", row_->id(0)));
  }

 private:
  void advance() {
    const std::int64_t last = row_ ? row_->id(0) : 0;
    row_ = table_.next();
    if (!row_) return;
    row_->expect_columns(17, 18,
                         "frame track class truncated occluded alpha box(4) size(3) X Y Z ry");
    if (row_->id(0) < last) row_->fail("frames go backwards");
  }

  std::optional<Label> read() {
    const std::string& name = row_->words[2];
    if (name == "DontCare") {
      ++dropped_["label dropped: DontCare"];
      return std::nullopt;
    }
    const auto* known = std::find(std::begin(kClasses), std::end(kClasses), name);
    if (known == std::end(kClasses)) row_->fail(fmt::format("unknown class '{}'", name));
    const Label label{row_->id(1), static_cast<std::size_t>(known - std::begin(kClasses)),
                      robot_point({row_->number(13), row_->number(14), row_->number(15)})};
    if (label.point.x() <= 0) {
      ++dropped_["label dropped: behind the camera"];
      return std::nullopt;
    }
    if (label.point.head<2>().norm() > max_range_) {
      ++dropped_["label dropped: too far away"];
      return std::nullopt;
    }
    return label;
  }

  double max_range_;
  DropReport& dropped_;
  TextTable table_;
  std::optional<TextRow> row_;
};

std::map<std::int64_t, Track> collect(const KittiTrackingOptions& options) {
  std::map<std::int64_t, Track> tracks;
  DropReport ignored;
  Labels labels(options, ignored);
  Poses poses(options);
  for (std::size_t i = 0; const auto pose = poses.next(); ++i) {
    for (const Label& label : labels.of(i)) {
      Track& track = tracks[label.track];
      track.class_index = label.class_index;
      const auto p = pose->composePoint({label.point.x(), label.point.y(), 0.0});
      track.add({p.x, p.y});
    }
  }
  labels.finish();
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
  DropReport dropped;
  const std::map<std::int64_t, Track> tracks = collect(options);
  Labels labels(options, dropped);
  Poses poses(options);
  Random random(options.noise.seed);
  std::optional<CPose3D> last;
  while (const auto pose = poses.next()) {
    const std::size_t i = log.steps();
    ImportedStep step;
    step.time = static_cast<double>(i) * options.period;
    step.truth = pose;
    if (last) step.motion = noisy_motion(*pose - *last, options.noise, false, random);
    last = pose;
    auto frame = planar_detections("CAMERA", options.detector, CPose3D());
    frame->class_names.assign(std::begin(kClasses), std::end(kClasses));
    for (const Label& label : labels.of(i)) {
      auto d = detection_of(label.point, false);
      set_noise(options.detector, d);
      d.class_scores = scores_of(label.class_index, options.class_accuracy, random);
      if (tracks.at(label.track).stands(options.still_rms)) {
        d.landmark_id = static_cast<std::int32_t>(label.track);
      }
      frame->detections.push_back(d);
    }
    step.observations.push_back(frame);
    log.add(step);
  }
  for (const auto& [reason, count] : dropped) log.drop(reason, count);
  for (const auto& [id, track] : tracks) {
    if (!track.stands(options.still_rms)) continue;
    const Eigen::Vector2d p = track.mean();
    log.true_landmark(id, {p.x(), p.y(), 0}, kClasses[track.class_index]);
  }
  return log.finish();
}

}  // namespace hybrid
