// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/kitti.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/kitti_odometry.h"
#include "mrpt_plugins/import/detail/oracle.h"

namespace hybrid {
namespace {

constexpr std::size_t kMinOracleSightings = 5;
constexpr double kPixelNoise = 2;    // pixels, of the edges of a box
constexpr double kRoadNoise = 0.01;  // rad, pitch of the camera relative to the road
constexpr double kShapeNoise = 0.3;  // m, from the centre of the visible part to that of the car
constexpr std::int64_t kCocoIds[] = {2, 3, 5, 7};

using mrpt::poses::CPose3D;

/// A car seen in an image.
struct BoxSighting {
  CObservationClassedBearingRange::Detection detection;
  Eigen::Vector3d point;  ///< Middle of the car in the frame of the robot [m].
};

/// Names of the classes a box can have.
const std::vector<std::string>& kitti_box_classes() {
  static const std::vector<std::string> names{"car", "motorbike", "bus", "truck"};
  return names;
}

struct Box {
  double left, top, width, height, confidence;
  std::size_t class_index;
};

/// A depth and its standard deviation [m].
struct Depth {
  double mean, sigma;
};

Depth depth_by_height(const Box& box, const KittiOptions& o) {
  const double z = o.focal * o.object_height / box.height;
  return {z, z * std::hypot(o.sigma_height / o.object_height, kPixelNoise / box.height)};
}

/// Depth at which the lower edge of the box meets the road; empty if it is above the horizon.
std::optional<Depth> depth_by_road(const Box& box, const KittiOptions& o) {
  const double below = box.top + box.height - o.center_v;
  if (below <= kPixelNoise) return std::nullopt;
  const double z = o.focal * o.camera_height / below;
  return Depth{z, z * std::hypot(kRoadNoise * o.focal, kPixelNoise) / below};
}

/// Sets `depth`, or returns why the box is dropped.
const char* find_depth(const Box& box, const KittiOptions& o, Depth& depth) {
  const Depth h = depth_by_height(box, o);
  const std::optional<Depth> road = depth_by_road(box, o);
  if (!road) return "box dropped: its lower edge is above the horizon";
  if (std::abs(h.mean - road->mean) > o.agreement * std::max(h.mean, road->mean)) {
    return "box dropped: depth by height and depth by road differ";
  }
  const double wh = 1 / (h.sigma * h.sigma), wr = 1 / (road->sigma * road->sigma);
  depth = {(wh * h.mean + wr * road->mean) / (wh + wr), 1 / std::sqrt(wh + wr)};
  return depth.mean > o.max_depth ? "box dropped: too far away" : nullptr;
}

BoxSighting sighting_of(const Box& box, const Depth& depth, const KittiOptions& o, bool is_3d) {
  const double u = box.left + 0.5 * box.width, v = box.top + 0.5 * box.height;
  const Eigen::Vector3d ray((u - o.center_u) / o.focal, (v - o.center_v) / o.focal, 1);
  const Eigen::Vector3d surface = depth.mean * ray;
  BoxSighting out;
  out.point = robot_point(surface + o.half_length * surface.normalized());
  out.detection = detection_of(out.point, is_3d);
  const double range = out.point.norm();
  out.detection.std_range = static_cast<float>(std::hypot(depth.sigma * ray.norm(), kShapeNoise));
  out.detection.std_yaw =
      static_cast<float>(std::hypot(kShapeNoise / range, kPixelNoise / o.focal));
  if (is_3d) {
    out.detection.std_pitch =
        static_cast<float>(std::hypot(o.sigma_height / range, kPixelNoise / o.focal));
  }
  const std::size_t classes = kitti_box_classes().size();
  const double others = (1 - box.confidence) / static_cast<double>(classes - 1);
  out.detection.class_scores.assign(classes, static_cast<float>(others));
  out.detection.class_scores[box.class_index] = static_cast<float>(box.confidence);
  return out;
}

/// Streams the boxes that determine the position of a car, in order of images. Counts the others in
/// `dropped`.
class Boxes {
 public:
  /// Throws Error for a missing file.
  Boxes(const KittiOptions& options, bool is_3d, DropReport& dropped);

  /// The boxes of one image; images must be asked for in order. Throws Error with file:line for
  /// malformed rows.
  std::vector<BoxSighting> of(std::size_t frame);

  /// Throws Error if there are boxes of later images.
  void finish() const;

 private:
  void advance();
  std::optional<BoxSighting> sighting();

  const KittiOptions& options_;
  bool is_3d_;
  DropReport& dropped_;
  TextReader table_;
  std::optional<TextRow> row_;
};

Boxes::Boxes(const KittiOptions& options, bool is_3d, DropReport& dropped)
    : options_(options), is_3d_(is_3d), dropped_(dropped), table_(options.boxes) {
  advance();
}

void Boxes::advance() {
  const std::int64_t last = row_ ? row_->id(0) : 0;
  row_ = table_.next();
  if (!row_) return;
  row_->expect(7, "frame x_min y_min width height coco_class confidence");
  if (row_->id(0) < last) row_->fail("frames go backwards");
}

std::vector<BoxSighting> Boxes::of(std::size_t frame) {
  std::vector<BoxSighting> out;
  for (; row_ && static_cast<std::size_t>(row_->id(0)) <= frame; advance()) {
    if (auto seen = sighting()) out.push_back(std::move(*seen));
  }
  return out;
}

void Boxes::finish() const {
  if (row_) row_->fail(fmt::format("image {}, after the end of the odometry", row_->id(0)));
}

std::optional<BoxSighting> Boxes::sighting() {
  Box box{row_->coordinate(1), row_->coordinate(2), row_->coordinate(3),
          row_->coordinate(4), row_->number(6),     0};
  if (box.width <= 0 || box.height <= 0) row_->fail(3, "box without width or height");
  if (box.confidence < 0 || box.confidence > 1) row_->fail(6, "confidence not within 0 and 1");
  const auto* known = std::find(std::begin(kCocoIds), std::end(kCocoIds), row_->id(5));
  if (known == std::end(kCocoIds)) {
    ++dropped_["box dropped: no vehicle"];
    return std::nullopt;
  }
  box.class_index = static_cast<std::size_t>(known - std::begin(kCocoIds));
  Depth depth{};
  if (const char* reason = find_depth(box, options_, depth)) {
    ++dropped_[reason];
    return std::nullopt;
  }
  return sighting_of(box, depth, options_, is_3d_);
}

/// The true poses, one for each image.
class Truth {
 public:
  Truth(const std::string& path, bool is_3d) : path_(path), is_3d_(is_3d) {
    if (!path.empty()) table_.emplace(path);
  }

  /// The next pose; empty without a file.
  std::optional<CPose3D> next() {
    if (!table_) return std::nullopt;
    const auto row = table_->next();
    if (!row)
      throw Error(fmt::format("{}: ends with pose {}, the odometry goes on", path_, count_));
    ++count_;
    const CPose3D pose = robot_pose(*row, 0);
    return is_3d_ ? pose : flattened(pose);
  }

  void finish() {
    if (!table_) return;
    if (const auto row = table_->next()) {
      row->fail(fmt::format("more than {} true poses, the odometry has no more", count_));
    }
  }

 private:
  std::string path_;
  bool is_3d_;
  std::optional<TextReader> table_;
  std::size_t count_ = 0;
};

/// True ids of all sightings in their order, by their positions in the plane according to the true
/// poses. Only ids with enough sightings.
std::vector<std::int32_t> true_ids(const KittiOptions& options, bool is_3d) {
  if (options.oracle_radius <= 0) return {};
  if (options.truth.empty()) throw Error("an oracle radius needs true poses");
  DropReport ignored;
  Boxes boxes(options, is_3d, ignored);
  TextReader truth(options.truth);
  std::vector<PlacedSighting> placed;
  for (std::size_t frame = 0; const auto row = truth.next(); ++frame) {
    const CPose3D pose = is_3d ? robot_pose(*row, 0) : flattened(robot_pose(*row, 0));
    for (const BoxSighting& s : boxes.of(frame)) {
      const Eigen::Vector3d q = transformed(pose, s.point);
      placed.push_back({{q.x(), q.y(), 0}});
    }
  }
  return number_by_place(placed, options.oracle_radius, kMinOracleSightings);
}

CObservationClassedBearingRange::Ptr make_frame(bool is_3d) {
  auto frame = planar_detections("CAMERA", {1.0, 0, 0.05, 0}, {});
  frame->has_pitch = is_3d;
  if (is_3d) frame->std_pitch = 0.05F;
  frame->class_names = kitti_box_classes();
  return frame;
}

}  // namespace

ImportReport import_kitti(const KittiOptions& options, const std::string& output) {
  LogWriter log(output);
  DropReport dropped;
  KittiOdometry odometry(options.odometry, options.covariances, options.inflate);
  Boxes boxes(options, odometry.is_3d(), dropped);
  Truth truth(options.truth, odometry.is_3d());
  const std::vector<std::int32_t> ids = true_ids(options, odometry.is_3d());
  auto id = ids.begin();
  std::optional<OdometryIncrement> motion;
  do {
    ImportedStep step;
    step.time = static_cast<double>(odometry.count()) * options.period;
    step.motion = motion;
    step.truth = truth.next();
    auto frame = make_frame(odometry.is_3d());
    for (BoxSighting& s : boxes.of(odometry.count())) {
      if (id != ids.end()) s.detection.true_landmark_id = *id++;
      frame->detections.push_back(std::move(s.detection));
    }
    step.observations.push_back(frame);
    log.used(odometry.share());
    log.add(step);
    motion = odometry.next(dropped);
  } while (motion);
  truth.finish();
  boxes.finish();
  for (const std::string& path : {options.odometry, options.boxes, options.truth}) {
    if (!path.empty()) log.note_end(path);
  }
  if (odometry.is_3d() && !options.covariances.empty()) log.note_end(options.covariances);
  for (const auto& [reason, count] : dropped) log.drop(reason, count);
  return log.finish();
}

}  // namespace hybrid
