// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/stata.h"

#include <algorithm>

#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/oracle.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

struct DetectorClass {
  std::int64_t number;
  const char* name;
};
constexpr std::size_t kMinObjectSightings = 5;
constexpr DetectorClass kObjectClasses[] = {
    {6, "keyboard"}, {9, "monitor"},  {11, "flower_pot"}, {12, "traffic_light"},
    {14, "cup"},     {16, "toy_car"}, {17, "chair"},      {19, "person"}};

/// Streams the detections, one key-frame after the other.
class Detections {
 public:
  Detections(const StataOptions& options, DropReport& dropped)
      : options_(options), dropped_(dropped), table_(options.folder + "/detections.txt") {
    advance();
  }

  CObservationClassedBearingRange::Ptr frame(std::int64_t number) {
    auto frame = planar_detections("CAMERA", options_.detector, {});
    frame->has_pitch = true;
    frame->std_pitch = frame->std_yaw;
    for (const DetectorClass& c : kObjectClasses) frame->class_names.emplace_back(c.name);
    for (; row_ && row_->id(0) == number; advance()) add(*frame);
    return frame;
  }

  /// Counts detections of no key-frame as dropped.
  void finish() {
    for (; row_; advance()) ++dropped_["detection dropped: of no key-frame"];
  }

 private:
  void advance() {
    const std::int64_t last = row_ ? row_->id(0) : 0;
    row_ = table_.next();
    if (!row_) return;
    row_->expect(11, "frame class score x y z size x1 y1 x2 y2");
    row_->numbers(6, 11);
    if (row_->id(0) < last) row_->fail("frames go backwards");
  }

  void add(CObservationClassedBearingRange& frame) {
    const auto* known =
        std::find_if(std::begin(kObjectClasses), std::end(kObjectClasses),
                     [&](const DetectorClass& c) { return c.number == row_->id(1); });
    if (known == std::end(kObjectClasses)) row_->fail(1, "unknown class " + in_quotes((*row_)[1]));
    const double score = row_->number(2);
    const Eigen::Vector3d camera(row_->coordinate(3), row_->coordinate(4), row_->coordinate(5));
    if (score < 0 || score > 1) row_->fail(2, "score not within 0 and 1");
    if (camera.z() <= 0) {
      ++dropped_["detection dropped: behind the camera"];
    } else if (score < options_.min_score) {
      ++dropped_["detection dropped: low score"];
    } else {
      auto d = detection_of(robot_point(camera), true);
      set_noise(options_.detector, d);
      const float others = static_cast<float>((1 - score) / (std::size(kObjectClasses) - 1));
      d.class_scores.assign(std::size(kObjectClasses), others);
      d.class_scores[static_cast<std::size_t>(known - kObjectClasses)] = static_cast<float>(score);
      frame.detections.push_back(d);
    }
  }

  const StataOptions& options_;
  DropReport& dropped_;
  TextReader table_;
  std::optional<TextRow> row_;
};

/// Streams the poses of the key-frames.
class Frames {
 public:
  explicit Frames(const StataOptions& options) : table_(options.folder + "/frames.txt") {}

  /// The next pose; empty after the last one.
  std::optional<CPose3D> next() {
    const auto row = table_.next();
    if (!row) return std::nullopt;
    if (row->id(0) != count_) row->fail("index out of order");
    ++count_;
    return robot_pose(*row, 2);
  }

  std::int64_t number() const { return count_ - 1; }
  double share() const { return table_.share(); }

 private:
  TextReader table_;
  std::int64_t count_ = 0;
};

/// True ids of all detections in their order, by their positions according to the poses.
std::vector<std::int32_t> true_ids(const StataOptions& options) {
  if (options.oracle_radius <= 0) return {};
  DropReport ignored;
  Detections detections(options, ignored);
  Frames frames(options);
  std::vector<PlacedSighting> placed;
  while (const auto pose = frames.next()) {
    const auto seen_there = detections.frame(frames.number());
    for (const auto& d : seen_there->detections) {
      const CPose3D seen =
          *pose + CPose3D(0, 0, 0, d.yaw, d.pitch, 0) + CPose3D(d.range, 0, 0, 0, 0, 0);
      const auto best = std::max_element(d.class_scores.begin(), d.class_scores.end());
      placed.push_back({{seen.x(), seen.y(), seen.z()},
                        static_cast<std::size_t>(best - d.class_scores.begin())});
    }
  }
  return number_by_place(placed, options.oracle_radius, kMinObjectSightings);
}

}  // namespace

ImportReport import_stata(const StataOptions& options, const std::string& output) {
  LogWriter log(output);
  const std::vector<std::int32_t> ids = true_ids(options);
  auto id = ids.begin();
  DropReport dropped;
  Detections detections(options, dropped);
  Frames frames(options);
  Random random(options.noise.seed);
  std::optional<CPose3D> last;
  while (const auto pose = frames.next()) {
    ImportedStep step;
    step.time = static_cast<double>(frames.number()) * options.period;
    step.truth = pose;
    if (last) step.motion = noisy_motion(*pose - *last, options.noise, true, random);
    last = pose;
    const auto seen = detections.frame(frames.number());
    for (auto& d : seen->detections) {
      if (id != ids.end()) d.true_landmark_id = *id++;
    }
    step.observations.push_back(seen);
    log.used(frames.share());
    log.add(step);
  }
  detections.finish();
  log.note_end(options.folder + "/frames.txt");
  log.note_end(options.folder + "/detections.txt");
  for (const auto& [reason, count] : dropped) log.drop(reason, count);
  return log.finish();
}

}  // namespace hybrid
