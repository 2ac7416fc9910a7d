// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/mrclam.h"

#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/detail/planar_truth.h"

namespace hybrid {
namespace {

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

/// Collects the measurements of one time and adds them to the log.
class Frame {
 public:
  Frame(const MrclamOptions& options, LogWriter& log)
      : options_(options),
        log_(log),
        odometry_(robot_file(options, "Odometry", "_changes"), read_command, options.walk),
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
      log_.add({time_, odometry_.move_to(time_), {seen_}, truth});
    } else {
      log_.drop("detection dropped: no true pose at its time", seen_->detections.size());
    }
    seen_.reset();
  }

  bool is_of(double time) const { return seen_ && time == time_; }
  double time() const { return time_; }
  CObservationClassedBearingRange& detections() { return *seen_; }

 private:
  const MrclamOptions& options_;
  LogWriter& log_;
  VelocityOdometry odometry_;
  PlanarTruth truth_;
  double time_ = 0;
  CObservationClassedBearingRange::Ptr seen_;
};

}  // namespace

ImportReport import_mrclam(const MrclamOptions& options, const std::string& output) {
  LogWriter log(output);
  const auto subject_of = read_barcodes(options.folder + "/Barcodes.dat");
  Frame frame(options, log);
  TextReader table(robot_file(options, "Measurement", ""));
  while (const auto row = table.next()) {
    row->expect(4, "time barcode range bearing");
    log.used(table.share());
    const double time = row->time(0);
    if (time < frame.time()) row->fail("time goes backwards");
    if (!frame.is_of(time)) frame.begin(time);
    CObservationClassedBearingRange::Detection d;
    d.range = static_cast<float>(row->coordinate(2));
    d.yaw = static_cast<float>(row->coordinate(3));
    set_noise(options.detector, d);
    const auto subject = subject_of.find(row->id(1));
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
