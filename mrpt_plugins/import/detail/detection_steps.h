// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <fmt/format.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/detail/fix_table.h"
#include "mrpt_plugins/import/detail/table_odometry.h"
#include "mrpt_plugins/import/detail/wandering_path.h"
#include "mrpt_plugins/import/detection_options.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/input/odometry_reset.h"

namespace hybrid {

/// Collects the detections of one time and adds them to the log as a step; satellite fixes between
/// become steps of their own.
class DetectionSteps {
 public:
  DetectionSteps(const DetectionSteps&) = delete;
  DetectionSteps& operator=(const DetectionSteps&) = delete;
  DetectionSteps(const DetectionTablesOptions& options, LogWriter& log)
      : options_(options), log_(log), odometry_(options.odometry) {
    if (!options.fixes.table.empty()) fixes_.emplace(options.fixes);
    odometry_.watch([this](const TimedPose& row) { add_reading(row); });
  }

  /// Starts an empty frame for the detections of a time.
  void begin(double time, bool has_range, bool has_pitch, const std::vector<std::string>& classes) {
    const auto& p = options_.sensor_pose;
    frame_ = planar_detections("DETECTOR", {options_.sigma_range, 0, options_.sigma_bearing, 0},
                               {p[0], p[1], p[2], p[3], p[4], p[5]});
    frame_->has_range = has_range;
    frame_->has_pitch = has_pitch;
    if (has_pitch) frame_->std_pitch = static_cast<float>(options_.sigma_bearing);
    frame_->fov_yaw = static_cast<float>(options_.fov);
    frame_->class_names = classes;
    time_ = time;
  }

  void end() {
    if (!frame_) return;
    if (!frame_->has_range) directions_ += frame_->detections.size();
    if (bare_) directions_ += bare_->detections.size();
    add_fixes_before(time_);
    const auto pose = odometry_.at(time_);
    if (!pose && count() > 0) {
      log_.drop("detection dropped: no odometry before or after it", count());
    }
    add_step(time_, pose, observations(), fixes_at(time_));
    frame_.reset();
    bare_.reset();
    ranges_.clear();
  }

  /// Adds a range to what has an id, without a direction [m].
  void add_range(double range, double sigma, std::int32_t id) {
    auto& seen = ranges_[sigma];
    if (!seen) {
      seen = mrpt::obs::CObservationBeaconRanges::Create();
      seen->sensorLabel = "DETECTOR";
      seen->stdError = static_cast<float>(sigma);
    }
    const auto& p = options_.sensor_pose;
    mrpt::obs::CObservationBeaconRanges::TMeasurement m;
    m.sensorLocationOnRobot = {p[0], p[1], p[2]};
    m.sensedDistance = static_cast<float>(range);
    m.beaconID = id;
    seen->sensedData.push_back(m);
  }

  /// Adds the fixes that are left, reads the rest of the odometry, and notes what is odd, where so
  /// many directions have an id.
  void finish(std::size_t identified) {
    add_fixes_before(std::numeric_limits<double>::infinity());
    odometry_.finish(log_);
    finish_fixes();
    ask_unit_of_times();
    if (directions_ == 0 || 2 * identified > directions_) return;
    log_.note(fmt::format(
        "{} directions without ranges and ids: a thing gets its place once the robot has passed it "
        "for about a tenth of its distance; what is straight ahead gets none (docs/range_only.md)",
        directions_));
  }

  bool is_of(double time) const { return frame_ && time == time_; }
  double time() const { return time_; }
  double start_of_odometry() const { return odometry_.start(); }
  CObservationClassedBearingRange& frame() { return *frame_; }
  /// Where directions go that have no range though others of the frame have.
  CObservationClassedBearingRange& directions() {
    if (!frame_->has_range) return *frame_;
    if (!bare_) {
      bare_ = std::make_shared<CObservationClassedBearingRange>(*frame_);
      bare_->sensorLabel = "DETECTOR_DIRECTIONS";
      bare_->has_range = false;
      bare_->detections.clear();
    }
    return *bare_;
  }
  bool is_3d() const { return odometry_.is_3d(); }

 private:
  using Observations = std::vector<mrpt::obs::CObservation::Ptr>;

  /// Adds a step; where its place is not known, nothing.
  void add_step(double time, const std::optional<mrpt::poses::CPose3D>& pose,
                Observations observations, const Observations& fixes) {
    if (!pose) {
      if (!fixes.empty()) log_.drop("fix dropped: no odometry before or after it", fixes.size());
      return;
    }
    placed_fixes_ += fixes.size();
    observations.insert(observations.end(), fixes.begin(), fixes.end());
    ImportedStep step{time, {}, std::move(observations), {}};
    if (odometry_.resets() > resets_) {
      log_.drop(OdometryReset::kDropped);
    } else if (way_) {
      step.motion = way_->to(*pose);
    }
    resets_ = odometry_.resets();
    if (!last_) first_ = time;
    last_is_read_ = last_ && newest_ > last_->time;
    if (last_is_read_ && time > newest_) log_.add_odometry(time, *pose, odometry_.is_3d());
    last_ = TimedPose{time, *pose};
    way_.emplace(*last_, odometry_.is_3d(), options_.walk_translation, options_.walk_rotation);
    newest_ = time;
    log_.add(step);
  }
  /// Adds a row of the odometry between steps, which tells where the robot was there.
  void add_reading(const TimedPose& row) {
    if (!last_ || row.time <= newest_) return;
    if (!last_is_read_) log_.add_odometry(last_->time, last_->pose, odometry_.is_3d());
    last_is_read_ = true;
    newest_ = row.time;
    way_->pass(row);
    log_.add_odometry(row.time, row.pose, odometry_.is_3d());
  }
  Observations fixes_at(double time) { return fixes_ ? fixes_->take(time) : Observations(); }
  /// Makes steps of the fixes before a time.
  void add_fixes_before(double end) {
    while (fixes_ && fixes_->time() < end) {
      const double time = fixes_->time();
      const Observations fixes = fixes_->take(time);
      if (options_.detections.empty()) log_.used(fixes_->share());
      add_step(time, odometry_.at(time), {}, fixes);
    }
  }
  /// Asks about times that make a robot move and see more slowly than any does.
  void ask_unit_of_times() const {
    constexpr double kLeastWay = 1, kSlow = 0.01, kApart = 20;  // m, m/s, s
    const double way = odometry_.way(), duration = odometry_.end() - odometry_.start();
    if (log_.steps() < 2 || way < kLeastWay || way >= kSlow * duration) return;
    const double apart = (last_->time - first_) / static_cast<double>(log_.steps() - 1);
    if (apart < kApart) return;
    log_.note(
        fmt::format("{}: the robot moves by {:.2g} m in a second, and steps are {:.4g} s "
                    "apart: are the times milliseconds? They are taken for seconds",
                    options_.odometry, way / duration, apart));
  }
  void finish_fixes() {
    if (!fixes_) return;
    fixes_->finish(log_);
    if (placed_fixes_ > 0) return;
    throw Error(
        fmt::format("{}: no fix has odometry around it: they are of {} to {} s, and the odometry "
                    "begins at {} s; times of both are of one clock",
                    options_.fixes.table, fixes_->first(), fixes_->last(), odometry_.start()));
  }
  Observations observations() const {
    if (ranges_.empty() && !bare_) return {frame_};
    Observations all;
    if (bare_) all = {frame_, bare_};
    for (const auto& [sigma, seen] : ranges_) all.push_back(seen);
    return all;
  }
  std::size_t count() const {
    std::size_t count = frame_->detections.size() + (bare_ ? bare_->detections.size() : 0);
    for (const auto& [sigma, seen] : ranges_) count += seen->sensedData.size();
    return count;
  }

  const DetectionTablesOptions& options_;
  LogWriter& log_;
  TableOdometry odometry_;
  std::optional<FixTable> fixes_;
  std::size_t placed_fixes_ = 0;
  std::size_t resets_ = 0;  // of the odometry up to the last step
  std::map<double, mrpt::obs::CObservationBeaconRanges::Ptr> ranges_;  // without directions, by
                                                                       // sigma
  CObservationClassedBearingRange::Ptr frame_, bare_;
  std::size_t directions_ = 0;        // without ranges
  double first_ = 0;                  // time of the first step
  std::optional<TimedPose> last_;     // step
  std::optional<WanderingPath> way_;  // from there on
  double newest_ = 0;                 // time of that or of the last row behind it
  bool last_is_read_ = false;         // the last step, or a row behind it, is in the log
  double time_ = -std::numeric_limits<double>::infinity();
};

}  // namespace hybrid
