// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/kitti_tracking.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/import/detail/camera.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

const char* const kClasses[] = {"Car",     "Van",  "Truck", "Pedestrian",
                                "Cyclist", "Tram", "Misc",  "Person_sitting"};
constexpr double kMinSightings = 3;
constexpr float kOwnScore = 0.9F;  // of the class of a detection

struct Label {
  std::int64_t track;
  std::size_t class_index;
  Eigen::Vector3d point;  // in the frame of the robot
};

/// Sums over the sightings of one object: of the position p of the robot and of the vector v from
/// the robot to the object, both in world axes. With the scale s of the poses, the object was seen
/// at s p + v.
struct Track {
  double count = 0;
  Eigen::Vector2d p = Eigen::Vector2d::Zero(), v = Eigen::Vector2d::Zero();
  double pp = 0, pv = 0, vv = 0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();  // p is relative to it
  std::size_t class_index = 0;

  void add(const Eigen::Vector2d& robot, const Eigen::Vector2d& seen) {
    if (count == 0) first = robot;
    const Eigen::Vector2d from_first = robot - first;
    ++count;
    p += from_first;
    v += seen;
    pp += from_first.squaredNorm();
    pv += from_first.dot(seen);
    vv += seen.squaredNorm();
  }
  double spread_pp() const { return pp - p.squaredNorm() / count; }
  double spread_pv() const { return pv - p.dot(v) / count; }
  double spread_vv() const { return vv - v.squaredNorm() / count; }
  Eigen::Vector2d mean(double scale) const { return scale * (first + p / count) + v / count; }
  bool stands(double scale, double rms) const {
    const double squares = scale * scale * spread_pp() + 2 * scale * spread_pv() + spread_vv();
    return count >= kMinSightings && squares <= rms * rms * count;
  }
};

using Tracks = std::map<std::int64_t, Track>;

/// Streams the poses of the robot, scaled.
class Poses {
 public:
  Poses(const std::string& path, double scale) : scale_(scale), table_(path) {}

  std::optional<CPose3D> next() {
    const auto row = table_.next();
    if (!row) return std::nullopt;
    const CPose3D pose = flattened(robot_pose(*row, 0));
    return CPose3D(scale_ * pose.x(), scale_ * pose.y(), 0, pose.yaw(), 0, 0);
  }

  double share() const { return table_.share(); }

 private:
  double scale_;
  TextReader table_;
};

/// Streams the labels in use; counts the others in `dropped`.
class Labels {
 public:
  Labels(const KittiTrackingOptions& options, DropReport& dropped)
      : max_range_(options.max_range), dropped_(dropped), table_(options.labels) {
    advance();
  }

  /// The labels of one frame; frames must be asked for in order.
  std::vector<Label> of(std::size_t frame) {
    std::vector<Label> out;
    for (; row_ && static_cast<std::size_t>(row_->id(0)) == frame; advance()) {
      if (auto label = read()) out.push_back(*label);
    }
    return out;
  }

  /// Throws Error if there are labels of later frames.
  void finish() const {
    if (row_) row_->fail(fmt::format("frame {} has no pose", row_->id(0)));
  }

 private:
  void advance() {
    const std::int64_t last = row_ ? row_->id(0) : 0;
    row_ = table_.next();
    if (!row_) return;
    row_->expect_same(columns_, 17,
                      "frame track class truncated occluded alpha box(4) size(3) X Y Z ry [score]");
    row_->expect(17, 18, "17 columns, or 18 with a score");
    row_->numbers(3, columns_);
    if (row_->id(0) < last) row_->fail("frames go backwards");
  }

  std::optional<Label> read() {
    std::string_view name = (*row_)[2];
    if (name == "Person") name = "Person_sitting";  // as label files of sets 17 and others have it
    if (name == "DontCare") {
      ++dropped_["label dropped: DontCare"];
      return std::nullopt;
    }
    const auto* known = std::find(std::begin(kClasses), std::end(kClasses), name);
    if (known == std::end(kClasses)) row_->fail(2, "unknown class " + in_quotes(name));
    const Label label{
        row_->id(1), static_cast<std::size_t>(known - std::begin(kClasses)),
        robot_point({row_->coordinate(13), row_->coordinate(14), row_->coordinate(15)})};
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
  TextReader table_;
  std::optional<TextRow> row_;
  std::size_t columns_ = 0;
};

Tracks collect(const KittiTrackingOptions& options) {
  Tracks tracks;
  DropReport ignored;
  Labels labels(options, ignored);
  Poses poses(options.poses, 1);
  for (std::size_t i = 0; const auto pose = poses.next(); ++i) {
    for (const Label& label : labels.of(i)) {
      Track& track = tracks[label.track];
      track.class_index = label.class_index;
      const Eigen::Vector2d robot(pose->x(), pose->y());
      track.add(robot, Eigen::Rotation2Dd(pose->yaw()) * label.point.head<2>());
    }
  }
  labels.finish();
  return tracks;
}

/// The scale of the poses that minimises the spread of static objects, by least squares.
double fitted_scale(const Tracks& tracks, double still_rms) {
  constexpr int kRounds = 5;  // the set of static objects depends on the scale
  double scale = 1;
  for (int i = 0; i < kRounds; ++i) {
    double pp = 0, pv = 0;
    for (const auto& [id, track] : tracks) {
      if (!track.stands(scale, still_rms)) continue;
      pp += track.spread_pp();
      pv += track.spread_pv();
    }
    if (pp <= 0 || pv >= 0) return scale;
    scale = -pv / pp;
  }
  return scale;
}

/// Scores that favour the true class with probability `accuracy`, else a random one.
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
  const Tracks tracks = collect(options);
  double scale = options.pose_scale;
  if (scale == 0) {
    scale = fitted_scale(tracks, options.still_rms);
    log.note(
        fmt::format("scale of the poses: {:.4f}, at which what stands is seen to stand", scale));
  }
  Labels labels(options, dropped);
  Poses poses(options.poses, scale);
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
      const Track& track = tracks.at(label.track);
      if (track.stands(scale, options.still_rms)) {
        d.landmark_id = static_cast<std::int32_t>(label.track);
      } else if (track.count >= kMinSightings) {
        d.true_landmark_id = static_cast<std::int32_t>(label.track);
        const Eigen::Vector3d place = transformed(*pose, {label.point.x(), label.point.y(), 0});
        log.true_mover(label.track, {place.x(), place.y(), 0});
      }
      frame->detections.push_back(d);
    }
    step.observations.push_back(frame);
    log.used(poses.share());
    log.add(step);
  }
  log.note_end(options.labels);
  log.note_end(options.poses);
  for (const auto& [reason, count] : dropped) log.drop(reason, count);
  for (const auto& [id, track] : tracks) {
    if (!track.stands(scale, options.still_rms)) continue;
    const Eigen::Vector2d p = track.mean(scale);
    log.true_landmark(id, {p.x(), p.y(), 0}, kClasses[track.class_index]);
  }
  return log.finish();
}

}  // namespace hybrid
