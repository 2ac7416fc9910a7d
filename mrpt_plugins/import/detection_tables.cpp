// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detection_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/import/detail/table_odometry.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

const std::vector<std::string> kDetectionColumns{
    "time", "range",   "yaw",         "pitch",     "class",       "score",
    "id",   "true_id", "sigma_range", "sigma_yaw", "sigma_pitch", "p_NAME"};

/// All classes of the columns p_NAME, or else in column class, sorted.
std::vector<std::string> classes_in(const std::string& path) {
  NamedTable table(path, kDetectionColumns, kColumnAliases);
  const std::vector<std::string> probable = table.probable_classes();
  if (!probable.empty()) return probable;
  std::set<std::string> names;
  while (table.has("class") && table.next()) {
    if (!table.word("class").empty()) names.insert(table.word("class"));
  }
  return {names.begin(), names.end()};
}

/// A number within 0 and 1.
double probability(const NamedTable& table, const std::string& name) {
  const double p = table.number(name);
  if (p < 0 || p > 1) table.fail(name, name + " not within 0 and 1");
  return p;
}

/// The columns p_NAME of a row; nothing where all are empty.
std::vector<float> probabilities_of(const NamedTable& table,
                                    const std::vector<std::string>& classes) {
  std::vector<float> scores;
  bool any = false;
  for (const std::string& name : classes) {
    const std::string column = std::string(kProbabilityPrefix) + name;
    const bool stated = table.has(column) && !table.word(column).empty();
    scores.push_back(stated ? static_cast<float>(probability(table, column)) : 0.0F);
    any = any || stated;
  }
  return any ? scores : std::vector<float>();
}

std::vector<float> scores_of(const NamedTable& table, const std::vector<std::string>& classes,
                             double usual) {
  if (!table.probable_classes().empty()) return probabilities_of(table, classes);
  if (!table.has("class") || table.word("class").empty()) return {};
  const auto it = std::find(classes.begin(), classes.end(), table.word("class"));
  if (it == classes.end()) {
    table.fail("class", fmt::format("unknown class {}; classes are: {}",
                                    in_quotes(table.word("class")), fmt::join(classes, " ")));
  }
  const bool scored = table.has("score") && !table.word("score").empty();
  const double score = scored ? probability(table, "score") : usual;
  if (classes.size() == 1) return {1.0F};
  const double others = (1 - score) / static_cast<double>(classes.size() - 1);
  std::vector<float> scores(classes.size(), static_cast<float>(others));
  scores[static_cast<std::size_t>(it - classes.begin())] = static_cast<float>(score);
  return scores;
}

OdometryIncrement motion_between(const CPose3D& from, const CPose3D& to, bool is_3d,
                                 const DetectionTablesOptions& options) {
  constexpr double kLeast = 1e-6;
  const CPose3D mean = to - from;
  const double way = mean.norm();
  const double vt = kLeast + options.walk_translation * options.walk_translation * way;
  const double vr = kLeast + options.walk_rotation * options.walk_rotation * way;
  if (!is_3d) {
    return planar_motion(mean.x(), mean.y(), mean.yaw(), Eigen::Vector3d(vt, vt, vr).asDiagonal());
  }
  Eigen::Matrix<double, 6, 1> variances;
  variances << vt, vt, vt, vr, vr, vr;
  return {mean, variances.asDiagonal(), false};
}

/// Collects the detections of one time and adds them to the log as a step.
class Steps {
 public:
  Steps(const DetectionTablesOptions& options, LogWriter& log)
      : options_(options), log_(log), odometry_(options.odometry) {}

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
    const auto pose = odometry_.at(time_);
    if (!pose) {
      log_.drop("detection dropped: no odometry before or after it", count());
    } else {
      ImportedStep step{time_, {}, observations(), {}};
      if (odometry_.resets() > resets_) {
        log_.drop("odometry dropped: it starts anew, so that the motion there is not known");
      } else if (last_) {
        step.motion = motion_between(*last_, *pose, odometry_.is_3d(), options_);
      }
      resets_ = odometry_.resets();
      last_ = pose;
      log_.add(step);
    }
    frame_.reset();
    ranges_.clear();
  }

  /// Adds a range to what has an id, without a direction [m].
  void add_range(double range, double sigma, std::int32_t id) {
    auto& seen = ranges_[sigma > 0 ? sigma : options_.sigma_range];
    if (!seen) {
      seen = mrpt::obs::CObservationBeaconRanges::Create();
      seen->sensorLabel = "DETECTOR";
      seen->stdError = static_cast<float>(sigma > 0 ? sigma : options_.sigma_range);
    }
    const auto& p = options_.sensor_pose;
    mrpt::obs::CObservationBeaconRanges::TMeasurement m;
    m.sensorLocationOnRobot = {p[0], p[1], p[2]};
    m.sensedDistance = static_cast<float>(range);
    m.beaconID = id;
    seen->sensedData.push_back(m);
  }

  void note() const { odometry_.note(log_); }

  bool is_of(double time) const { return frame_ && time == time_; }
  double time() const { return time_; }
  double start_of_odometry() const { return odometry_.start(); }
  CObservationClassedBearingRange& frame() { return *frame_; }

 private:
  std::vector<mrpt::obs::CObservation::Ptr> observations() const {
    if (ranges_.empty()) return {frame_};
    std::vector<mrpt::obs::CObservation::Ptr> all;
    for (const auto& [sigma, seen] : ranges_) all.push_back(seen);
    return all;
  }
  std::size_t count() const {
    std::size_t count = frame_->detections.size();
    for (const auto& [sigma, seen] : ranges_) count += seen->sensedData.size();
    return count;
  }

  const DetectionTablesOptions& options_;
  LogWriter& log_;
  TableOdometry odometry_;
  std::size_t resets_ = 0;  // of the odometry up to the last step
  std::map<double, mrpt::obs::CObservationBeaconRanges::Ptr> ranges_;  // without directions, by
                                                                       // sigma
  CObservationClassedBearingRange::Ptr frame_;
  std::optional<CPose3D> last_;
  double time_ = -std::numeric_limits<double>::infinity();
};

void add_detection(const NamedTable& table, const std::vector<std::string>& classes,
                   double usual_score, CObservationClassedBearingRange& frame) {
  CObservationClassedBearingRange::Detection d;
  if (frame.has_range) d.range = static_cast<float>(table.number("range"));
  d.yaw = static_cast<float>(table.angle("yaw"));
  if (frame.has_pitch) d.pitch = static_cast<float>(table.angle("pitch"));
  if (const auto id = table.id("id")) d.landmark_id = static_cast<std::int32_t>(*id);
  if (const auto id = table.id("true_id")) d.true_landmark_id = static_cast<std::int32_t>(*id);
  d.std_range = static_cast<float>(table.sigma("sigma_range"));
  d.std_yaw = static_cast<float>(table.sigma("sigma_yaw"));
  d.std_pitch = static_cast<float>(table.sigma("sigma_pitch"));
  d.class_scores = scores_of(table, classes, usual_score);
  frame.detections.push_back(std::move(d));
}

}  // namespace

ImportReport import_detection_tables(const DetectionTablesOptions& options,
                                     const std::string& output) {
  if (options.sensor_pose.size() != 6) throw Error("a sensor pose has six numbers");
  if (!(options.score > 0 && options.score <= 1))
    throw Error("--score must be above 0 and at most 1");
  LogWriter log(output);
  const std::vector<std::string> classes =
      options.classes.empty() ? classes_in(options.detections) : options.classes;
  NamedTable table(options.detections, kDetectionColumns, kColumnAliases);
  const bool has_yaw = table.has("yaw");
  if (has_yaw || !table.has("range") || !table.has("id")) table.require({"time", "yaw"});
  table.require({"time"});
  for (const std::string& name : table.probable_classes()) {
    if (std::find(classes.begin(), classes.end(), name) == classes.end()) {
      table.refuse(fmt::format("column p_{}: unknown class; classes are: {}", name,
                               fmt::join(classes, " ")));
    }
  }
  if (!table.probable_classes().empty() && (table.has("class") || table.has("score"))) {
    table.refuse("columns p_NAME beside class or score: one or the other");
  }
  if (table.has("class") && !table.has("score") && options.score == 1 && classes.size() > 1) {
    log.note(options.detections +
             ": no column score: classes are taken as certain; where the detector may be wrong, "
             "--score tells how often it is right");
  }
  Steps steps(options, log);
  double first = 0;
  while (table.next()) {
    log.used(table.share());
    const double time = table.time();
    if (!std::isfinite(steps.time())) first = time;
    if (time < steps.time()) table.fail("time", "time goes backwards");
    if (!steps.is_of(time)) {
      steps.end();
      steps.begin(time, table.has("range"), table.has("pitch"), classes);
    }
    if (table.has("range") && table.number("range") <= 0) {
      log.drop("detection dropped: range not positive");
    } else if (!has_yaw) {
      steps.add_range(table.number("range"), table.sigma("sigma_range"),
                      static_cast<std::int32_t>(table.id("id").value_or(-1)));
    } else {
      add_detection(table, classes, options.score, steps.frame());
    }
  }
  steps.end();
  steps.note();
  for (const std::string& name : table.ignored()) {
    log.note(fmt::format("{}: column {} is left aside", table.path(), name));
  }
  table.note_blanks(log);
  log.note_end(options.odometry);
  log.note_end(options.detections);
  if (log.steps() == 0) {
    throw Error(
        fmt::format("{}: no detection has odometry around it: they are of {} to {} s, and "
                    "the odometry begins at {} s; times of both are of one clock",
                    options.detections, first, steps.time(), steps.start_of_odometry()));
  }
  return log.finish();
}

}  // namespace hybrid
