// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/stata.h"

#include <fmt/format.h>

#include <algorithm>

#include "mrpt_plugins/import/camera.h"
#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

struct DetectorClass {
  std::int64_t number;
  const char* name;
};
constexpr DetectorClass kClasses[] = {{6, "keyboard"},       {9, "monitor"}, {11, "flower_pot"},
                                      {12, "traffic_light"}, {14, "cup"},    {16, "toy_car"},
                                      {17, "chair"},         {19, "person"}};

/// The detections file, one key-frame after the other.
class Detections {
 public:
  Detections(const StataOptions& options, LogWriter& log)
      : options_(options), log_(log), table_(options.folder + "/detections.txt") {
    advance();
  }

  CObservationClassedBearingRange::Ptr frame(std::int64_t number) {
    auto frame = planar_detections("CAMERA", options_.sigma_range, options_.sigma_bearing, {});
    frame->has_pitch = true;
    frame->std_pitch = static_cast<float>(options_.sigma_bearing);
    for (const DetectorClass& c : kClasses) frame->class_names.emplace_back(c.name);
    for (; row_ && row_->id(0) == number; advance()) add(*frame);
    return frame;
  }

  /// Counts what belongs to no key-frame.
  void finish() {
    for (; row_; advance()) log_.drop("detection dropped: of no key-frame");
  }

 private:
  void advance() {
    const std::int64_t last = row_ ? row_->id(0) : 0;
    row_ = table_.next();
    if (!row_) return;
    row_->expect_columns(11, 11, "frame class score x y z size x1 y1 x2 y2");
    if (row_->id(0) < last) row_->fail("frames go backwards");
  }

  void add(CObservationClassedBearingRange& frame) {
    const auto* known =
        std::find_if(std::begin(kClasses), std::end(kClasses),
                     [&](const DetectorClass& c) { return c.number == row_->id(1); });
    if (known == std::end(kClasses)) row_->fail(fmt::format("unknown class {}", row_->words[1]));
    const double score = row_->number(2);
    const Eigen::Vector3d camera(row_->number(3), row_->number(4), row_->number(5));
    if (score < 0 || score > 1) row_->fail("score not within 0 and 1");
    if (camera.z() <= 0) {
      log_.drop("detection dropped: behind the camera");
    } else if (score < options_.min_score) {
      log_.drop("detection dropped: low score");
    } else {
      auto d = detection_of(robot_point(camera), true);
      const float others = static_cast<float>((1 - score) / (std::size(kClasses) - 1));
      d.class_scores.assign(std::size(kClasses), others);
      d.class_scores[static_cast<std::size_t>(known - kClasses)] = static_cast<float>(score);
      frame.detections.push_back(d);
    }
  }

  const StataOptions& options_;
  LogWriter& log_;
  TextTable table_;
  std::optional<TextRow> row_;
};

}  // namespace

ImportReport import_stata(const StataOptions& options, const std::string& output) {
  LogWriter log(output);
  Detections detections(options, log);
  Random random(options.noise.seed);
  TextTable frames(options.folder + "/frames.txt");
  std::optional<CPose3D> last;
  while (const auto row = frames.next()) {
    row->expect_columns(14, 14, "index seq and a 3x4 matrix");
    if (static_cast<std::size_t>(row->id(0)) != log.steps()) row->fail("index out of order");
    ImportedStep step;
    step.time = static_cast<double>(log.steps()) * options.period;
    step.truth = robot_pose(*row, 2);
    if (last) step.motion = noisy_motion(*step.truth - *last, options.noise, true, random);
    last = step.truth;
    step.observations.push_back(detections.frame(row->id(0)));
    log.add(step);
  }
  detections.finish();
  return log.finish();
}

}  // namespace hybrid
