// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/mrclam.h"

#include <fmt/format.h>
#include <mrpt/math/wrap2pi.h>
#include <mrpt/poses/CPose3D.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/io/text_reader.h"
#include "libhybrid/uncertainty/sensor_delay.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

/// Streams true poses in the plane, rows `time x y angle`, and interpolates them.
class PlanarTruth {
 public:
  explicit PlanarTruth(const std::string& path) : table_(path) {}

  /// The pose at `time`, which must not be before that of the last call; empty outside the times of
  /// the file.
  std::optional<mrpt::poses::CPose3D> at(double time);

 private:
  struct Row {
    double time, x, y, angle;
  };

  void advance();

  TextReader table_;
  std::optional<Row> before_, after_;
};

void PlanarTruth::advance() {
  before_ = after_;
  const auto row = table_.next();
  after_.reset();
  if (!row) return;
  row->expect(4, "time x y angle");
  after_ = Row{row->time(0), row->coordinate(1), row->coordinate(2), row->coordinate(3)};
  if (before_ && after_->time < before_->time) row->fail("time goes backwards");
}

std::optional<mrpt::poses::CPose3D> PlanarTruth::at(double time) {
  if (!before_) advance();
  while (!before_ || (after_ && after_->time < time)) {
    advance();
    if (!before_ && !after_) return std::nullopt;
  }
  if (!after_ || before_->time > time) return std::nullopt;
  const double length = after_->time - before_->time;
  const double f = length > 0 ? (time - before_->time) / length : 0.0;
  const double turn = mrpt::math::wrapToPi(after_->angle - before_->angle);
  return mrpt::poses::CPose3D(before_->x + f * (after_->x - before_->x),
                              before_->y + f * (after_->y - before_->y), 0,
                              before_->angle + f * turn, 0, 0);
}

constexpr std::int64_t kRobots = 5;      // subjects 1 to 5; landmarks have higher numbers
constexpr std::int64_t kRobotId = -100;  // less the number of a robot is its id in the log

/// The file of a robot, or its thinned form if the full one is missing.
std::string robot_file(const MrclamOptions& options, const char* kind, const char* thinned) {
  const std::string stem = fmt::format("{}/Robot{}_{}", options.folder, options.robot, kind);
  const std::string full = stem + ".dat";
  return std::filesystem::exists(full) ? full : stem + thinned + ".dat";
}

std::map<std::int64_t, std::int64_t> read_barcodes(const std::string& path) {
  std::map<std::int64_t, std::int64_t> subject_of;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(2, "subject barcode");
    if (!subject_of.emplace(row->id(1), row->id(0)).second) row->fail(1, "barcode listed twice");
  }
  return subject_of;
}

Velocity read_command(const TextRow& row) {
  row.expect(3, "time forward_velocity angular_velocity");
  return {row.time(0), row.coordinate(1), row.coordinate(2)};
}

void add_landmarks(const std::string& path, LogWriter& log) {
  TextReader table(path);
  while (const auto row = table.next()) {
    if (row->size() != 5) row->expect(3, "subject x y, or subject x y x-std y-std");
    row->numbers(3, row->size());
    log.true_landmark(row->id(0), {row->coordinate(1), row->coordinate(2), 0.0});
  }
}

struct Measurement {
  double time = 0;
  std::int64_t barcode = 0;
  CObservationClassedBearingRange::Detection detection;
};

std::vector<Measurement> read_measurements(const MrclamOptions& options) {
  std::vector<Measurement> measurements;
  TextReader table(robot_file(options, "Measurement", ""));
  while (const auto row = table.next()) {
    row->expect(4, "time barcode range bearing");
    Measurement m{row->time(0), row->id(1), {}};
    if (!measurements.empty() && m.time < measurements.back().time) {
      row->fail("time goes backwards");
    }
    m.detection.range = static_cast<float>(row->coordinate(2));
    m.detection.yaw = static_cast<float>(row->coordinate(3));
    set_noise(options.detector, m.detection);
    measurements.push_back(m);
  }
  return measurements;
}

VelocityOdometry commands(const MrclamOptions& options) {
  return {robot_file(options, "Odometry", "_changes"), read_command, options.walk};
}

/// The delay of the camera by what it saw, whatever the barcodes say.
SensorDelay estimate_delay(const MrclamOptions& options,
                           const std::vector<Measurement>& measurements) {
  constexpr double kSample = 0.02, kMargin = 2;  // s
  std::vector<TimedSightings> frames;
  for (const Measurement& m : measurements) {
    if (frames.empty() || frames.back().time != m.time) frames.push_back({m.time, {}, {}});
    const auto& [range, yaw] = std::pair(m.detection.range, m.detection.yaw);
    MeasuredPoint seen{Eigen::Vector2d(range, yaw), Eigen::Matrix2d::Zero()};
    seen.covariance.diagonal() << std::pow(m.detection.std_range, 2),
        std::pow(m.detection.std_yaw, 2);
    frames.back().seen.push_back(seen);
  }
  std::vector<OdometryPose> path;
  VelocityOdometry odometry = commands(options);
  mrpt::poses::CPose3D pose;
  for (std::size_t i = 0; !frames.empty(); ++i) {
    const double time = frames.front().time - kMargin + kSample * static_cast<double>(i);
    pose = pose + odometry.move_to(time).mean;
    path.push_back({time, to_se3(pose)});
    if (time > frames.back().time + kMargin) break;
  }
  return estimate_sensor_delay(path, frames);
}

/// Collects the measurements of one time and adds them to the log.
class Frame {
 public:
  Frame(const MrclamOptions& options, double delay, LogWriter& log)
      : options_(options),
        delay_(delay),
        log_(log),
        odometry_(commands(options)),
        truth_(robot_file(options, "Groundtruth", "_10th")) {}

  /// Ends the last frame and starts one at `time`.
  void begin(double time) {
    end();
    time_ = time;
    seen_ = planar_detections("CAMERA", options_.detector, {});
  }

  void end() {
    if (!seen_) return;
    const auto truth = truth_.at(time_);
    if (truth) {
      log_.add({time_, odometry_.move_to(time_ - delay_), {seen_}, truth});
    } else {
      log_.drop("detection dropped: no true pose at its time", seen_->detections.size());
    }
    seen_.reset();
  }

  bool is_of(double time) const { return seen_ && time == time_; }
  CObservationClassedBearingRange& detections() { return *seen_; }

 private:
  const MrclamOptions& options_;
  double delay_;
  LogWriter& log_;
  VelocityOdometry odometry_;
  PlanarTruth truth_;
  double time_ = 0;
  CObservationClassedBearingRange::Ptr seen_;
};

/// The delay to correct, with a note for the user.
double delay_of(const MrclamOptions& options, const std::vector<Measurement>& measurements,
                LogWriter& log) {
  if (options.delay) return *options.delay;
  const SensorDelay delay = estimate_delay(options, measurements);
  if (!delay.is_significant()) {
    log.note("the log tells of no delay of the camera; none is corrected");
    return 0;
  }
  log.note(fmt::format("the camera is {:.3f} +- {:.3f} s behind the velocity commands: corrected",
                       delay.seconds, delay.sigma));
  return delay.seconds;
}

}  // namespace

ImportReport import_mrclam(const MrclamOptions& options, const std::string& output) {
  LogWriter log(output);
  const auto subject_of = read_barcodes(options.folder + "/Barcodes.dat");
  const std::vector<Measurement> measurements = read_measurements(options);
  Frame frame(options, delay_of(options, measurements, log), log);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    const Measurement& m = measurements[i];
    log.used(static_cast<double>(i + 1) / static_cast<double>(measurements.size()));
    if (!frame.is_of(m.time)) frame.begin(m.time);
    CObservationClassedBearingRange::Detection d = m.detection;
    const auto subject = subject_of.find(m.barcode);
    if (subject == subject_of.end()) {
      log.drop("detection dropped: barcode of nothing listed");
      continue;
    }
    if (subject->second > kRobots) {
      d.landmark_id = static_cast<std::int32_t>(subject->second);
    } else if (options.keep_robots) {
      d.landmark_id = static_cast<std::int32_t>(kRobotId - subject->second);
    } else {
      log.drop("detection dropped: another robot");
      continue;
    }
    frame.detections().detections.push_back(d);
  }
  frame.end();
  add_landmarks(options.folder + "/Landmark_Groundtruth.dat", log);
  for (const std::string& path :
       {robot_file(options, "Odometry", "_changes"), robot_file(options, "Groundtruth", "_10th"),
        robot_file(options, "Measurement", ""), options.folder + "/Barcodes.dat",
        options.folder + "/Landmark_Groundtruth.dat"}) {
    log.note_end(path);
  }
  return log.finish();
}

}  // namespace hybrid
