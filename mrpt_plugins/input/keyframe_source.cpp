// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/keyframe_source.h"

#include <mrpt/core/bits_math.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "libhybrid/uncertainty/sensor_alignment.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/clouds.h"

namespace hybrid {
namespace {

constexpr std::size_t kLookAhead = 100;  // keyframes

/// Takes the detections of robots out of a frame; nothing where there are none. Those whose id is
/// hidden stay, as detections of nothing in particular.
std::optional<DetectionFrame> take_robots(DetectionFrame& frame,
                                          const std::set<std::int64_t>& robots) {
  if (robots.empty()) return std::nullopt;
  for (Detection& d : frame.detections) {
    if (!d.id && d.true_id && robots.count(*d.true_id) != 0) d.true_id.reset();
  }
  const auto is_robot = [&](const Detection& d) { return d.id && robots.count(*d.id) != 0; };
  const auto first = std::stable_partition(frame.detections.begin(), frame.detections.end(),
                                           [&](const Detection& d) { return !is_robot(d); });
  if (first == frame.detections.end()) return std::nullopt;
  DetectionFrame out = frame;
  out.detections.assign(first, frame.detections.end());
  frame.detections.erase(first, frame.detections.end());
  return out;
}

/// Hides the ids of what is no robot: all, or those of two things.
void hide_ids(const LogCorrection& correction, const std::set<std::int64_t>& robots,
              DetectionFrame& frame) {
  for (Detection& d : frame.detections) {
    if (!d.id || robots.count(*d.id) != 0) continue;
    if (correction.hides_ids || correction.shared_ids.count(*d.id) != 0) d.id.reset();
  }
}

/// How often something was of the plane or of space.
struct Votes {
  std::size_t plane = 0, space = 0;
  void add(bool is_space) { ++(is_space ? space : plane); }
  bool is_space() const { return space > plane; }
};

Dimension parse_dimension(const std::string& text) {
  if (text == "2") return Dimension::kPlane;
  return text == "3" ? Dimension::kSpace : Dimension::kAuto;
}

NoiseSource parse_noise(const std::string& name) {
  if (name == "auto") return NoiseSource::kAuto;
  return name == "stated" ? NoiseSource::kStated : NoiseSource::kMeasured;
}

IdSource parse_ids(const std::string& text) {
  if (text == "none") return IdSource::kNone;
  return text == "truth" ? IdSource::kTruth : IdSource::kLog;
}

/// Leaves out what a delayed sensor saw before the odometry begins, or after it ends.
void drop_if_unplaced(const LogCorrection& correction, DetectionFrame& frame, DropReport& dropped) {
  const auto found = correction.sensors.find(frame.sensor_label);
  if (found == correction.sensors.end() || found->second.delay == 0) return;
  if (!correction.path || correction.path->empty()) return;
  const double time = frame.time - found->second.delay;
  if (time >= correction.path->front().time && time <= correction.path->back().time) return;
  if (frame.detections.empty()) return;
  dropped["detection dropped: no odometry of its time, clock corrected"] += frame.detections.size();
  frame.detections.clear();
}

/// Section [keyframes].
void read_keyframes(IniFile& ini, SourceOptions& options) {
  IniSection keyframes =
      ini.section("keyframes",
                  "A frame becomes a pose of the map once any threshold that is set is reached. "
                  "With all at 0 every frame does");
  KeyframeOptions& k = options.keyframes;
  keyframes.read("min_distance", k.min_distance,
                 "since the keyframe before [m]; 0: never. Where laser scans or fixes alone are "
                 "mapped: 0.5 unless this or a time is given",
                 kLength);
  k.min_angle = keyframes.degrees("min_angle_deg", 0.0,
                                  "rotation since then; 0: never. Where laser scans or fixes alone "
                                  "are mapped: 20 unless this or a time is given",
                                  {0, 360});
  const bool by_time = keyframes.has("min_time");
  options.has_keyframe_distance = by_time || keyframes.has("min_distance");
  options.has_keyframe_angle = by_time || keyframes.has("min_angle_deg");
  keyframes.read("min_time", k.min_time, "since then [s]; 0: never", kDuration);
  keyframes.replaces("tracklets", "gather");
  keyframes.read(
      "tracklets", options.tracklets,
      "follow detections between keyframes by odometry and hand each thing on as one detection; "
      "otherwise what is seen between keyframes is left out, unless landmarks get extents");
  keyframes.read("common_noise", options.tracker.common,
                 "tracklets: share of the variance that all detections of one thing have in "
                 "common, so that it does not average out",
                 kProbability);
  keyframes.read("common_noise_s", options.tracker.lasts,
                 "tracklets: how long that part lasts; with keyframes more frequent than this, "
                 "each tells as much less [s]",
                 kDuration);
}

/// Section [sensor].
void read_sensor(IniFile& ini, SourceOptions& options) {
  IniSection sensor = ini.section(
      "sensor", "Which measurements of range and bearing are accepted, and their noise");
  DetectionOptions& d = options.detections;
  sensor.read("max_range", d.max_range, "longer ranges are dropped [m]", kPositiveLength);
  sensor.read("sigma_range", d.sigma_range, "standard deviation of ranges [m]; 0: as the log says",
              or_zero(kSigmaMetres));
  d.sigma_yaw =
      sensor.degrees("sigma_yaw_deg", 0.0, "of yaw; 0: as the log says", or_zero(kSigmaDegrees));
  d.sigma_pitch = sensor.degrees("sigma_pitch_deg", 0.0, "of pitch; 0: as the log says",
                                 or_zero(kSigmaDegrees));

  ScanOptions& scans = options.scans;
  scans.max_range = d.max_range;
  scans.field_of_view = sensor.degrees(
      "fov_deg", 0.0,
      "field of view of laser scans, from the first ray to the last; 0: as the log says", {0, 360});

  options.noise = parse_noise(sensor.choice(
      "noise", "auto", {"auto", "stated", "measured"},
      "measured: noise of detections and odometry, sign and delay of a sensor, its mounting and "
      "ids that do not last are measured before the log is mapped, and used where it tells them "
      "(sigmas given here go first); stated: the log is taken at its word; auto: it is mapped as "
      "stated, and as measured where the map says of itself that it is wrong (health)"));
  d.ids = parse_ids(sensor.choice(
      "ids", "log", {"log", "none", "truth"},
      "landmark ids the mapping sees. log: those of the sensor; none: hidden, for unknown "
      "association; truth: the true ones where the log has them, for comparison"));
}

}  // namespace

SourceOptions read_source_options(IniFile& ini) {
  SourceOptions options;
  IniSection map = ini.section("map", "What kind of map is made");
  options.dimension = parse_dimension(map.choice(
      "dimension", "auto", {"auto", "2", "3"},
      "2: poses x, y, yaw and points x, y; 3: poses and points in space; auto: as the log needs"));
  read_keyframes(ini, options);
  read_sensor(ini, options);

  IniSection reader = ini.section("reader", "What a log may not say by itself");
  for (const char* key : {"odometry_sigma_m", "odometry_sigma_deg", "period", "max_speed"}) {
    reader.replaces(key, key, "log");
  }
  MotionModel& m = options.reader.motion_model;
  reader.read("odometry_sigma_m", m.minStdXY,
              "least sigma of CObservationOdometry, which carries none", kSigmaMetres);
  m.minStdPHI = reader.degrees("odometry_sigma_deg", mrpt::RAD2DEG(m.minStdPHI),
                               "the same for the angle", kSigmaDegrees);
  options.correction.translation = options.correction.rotation =
      reader.get("odometry_sigma_factor", 1.0, "of all odometry, as it is stated", kPositive);
  reader.read(
      "clock_offset", options.reader.clock_offset,
      "added to the time stamps of the log, so that those of several robots are of one clock [s]",
      {-1e9, 1e9});
  reader.read("period", options.reader.period, "between frames without a time stamp [s]",
              kPositiveDuration);
  reader.read("arrival_window", options.reader.arrival_window,
              "single observations are put in the order of their stamps where they arrive at most "
              "so much later than others, but not those of standard input [s]",
              kDuration);
  reader.read("max_speed", options.reader.max_speed,
              "odometry that leads farther in the time between frames, or in a period where that "
              "is longer, is dropped as damaged [m/s]",
              {1e-3, 1e4});
  return options;
}

KeyframeSource::KeyframeSource(const std::string& rawlog, const SourceOptions& options)
    : options_(options),
      reader_(rawlog, options.reader),
      policy_(options.keyframes),
      tracker_(options.tracker) {}

std::optional<Keyframe> KeyframeSource::next() {
  if (ahead_.empty()) {
    std::optional<Keyframe> keyframe = read();
    progress_ = share_read();
    return keyframe;
  }
  Ahead first = std::move(ahead_.front());
  ahead_.pop_front();
  progress_ = first.progress;
  return std::move(first.keyframe);
}

std::optional<double> KeyframeSource::share_read() const {
  if (options_.steps == 0) return reader_.progress();
  return std::min(1.0, static_cast<double>(steps_read_) / static_cast<double>(options_.steps));
}

bool KeyframeSource::is_3d() {
  if (options_.dimension != Dimension::kAuto) return options_.dimension == Dimension::kSpace;
  while (ahead_.size() < kLookAhead) {
    std::optional<Keyframe> keyframe = read();
    if (!keyframe) break;
    ahead_.push_back({std::move(*keyframe), share_read()});
  }
  Votes odometry;
  std::map<std::string, Votes> sensors;
  for (const auto& [keyframe, progress] : ahead_) {
    if (keyframe.odometry) odometry.add(!keyframe.odometry->is_planar);
    for (const DetectionFrame& frame : keyframe.detections) {
      if (frame.detections.empty()) continue;
      sensors[frame.sensor_label].add(frame.is_3d || is_tilted(frame.T_robot_sensor));
    }
    for (const auto& observation : keyframe.observations) {
      if (is_cloud(*observation)) sensors[observation->sensorLabel].add(true);
    }
  }
  return odometry.is_space() || std::any_of(sensors.begin(), sensors.end(), [](const auto& sensor) {
           return sensor.second.is_space();
         });
}

/// Passes the detections of a step to the tracker. At a keyframe, replaces them by its tracklets;
/// directions, which no range joins, stay as they are.
void KeyframeSource::track(const LogStep& step, bool is_keyframe,
                           std::vector<DetectionFrame>& detections) {
  if (step.odometry) {
    tracker_.move(to_isometry(step.odometry->mean), step.odometry->covariance);
  } else {
    const std::size_t lost = tracker_.forget();
    if (lost > 0) dropped_["detection dropped: no odometry from there to a keyframe"] += lost;
  }
  const auto ranged =
      std::stable_partition(detections.begin(), detections.end(),
                            [](const DetectionFrame& frame) { return !frame.has_range; });
  std::for_each(ranged, detections.end(),
                [&](const DetectionFrame& frame) { tracker_.take(frame); });
  if (!is_keyframe) return;
  detections.erase(ranged, detections.end());
  for (DetectionFrame& tracklets : tracker_.release()) detections.push_back(std::move(tracklets));
}

void KeyframeSource::collect_scans(const LogStep& step) {
  scans_.move(step.odometry, dropped_);
  for (const auto& observation : step.observations) {
    auto scan = scan_in(*observation, options_.scans, dropped_);
    if (!scan) continue;
    scan->time = step.time;
    options_.correction.correct(observation->sensorLabel, *scan);
    scans_.add(std::move(*scan), dropped_);
    const bool is_mended = options_.scans.field_of_view > 0 ||
                           options_.correction.lasers.count(observation->sensorLabel) != 0;
    if (!is_mended && is_halved_scan(*observation)) ++halved_scans_;
  }
}

void KeyframeSource::collect_fixes(const LogStep& step) {
  fixes_.move(step.time, step.odometry, dropped_);
  for (const auto& observation : step.observations) {
    auto fix = fix_in(*observation, dropped_);
    if (!fix) continue;
    if (fix->fix.time != 0) fix->fix.time += options_.reader.clock_offset;
    options_.correction.correct(fix->fix);
    fixes_.add(std::move(*fix), dropped_);
  }
}

void KeyframeSource::collect_poses(const LogStep& step) {
  if (!step.odometry) between_.lose(step.time);
  if (step.odometry) T_start_step_ = T_start_step_ * to_isometry(step.odometry->mean);
  for (const PoseBetween& entry : step.between) {
    between_.add(entry.time, T_start_step_ * entry.T_pose_robot);
  }
}

std::vector<PoseBetween> KeyframeSource::rest() const {
  return between_.rest();
}

DropReport KeyframeSource::warnings() const {
  DropReport all = reader_.warnings();
  if (halved_scans_ > 0) {
    all["scan of 180 rays over 90 degrees, as old imports of CARMEN logs make of 180 degrees: "
        "--set sensor.fov_deg=180 mends that"] = halved_scans_;
  }
  return all;
}

/// The keyframe of a step, whose detections it has already.
Keyframe KeyframeSource::make_keyframe(LogStep& step, Keyframe keyframe) {
  keyframe.row = step.index;
  keyframe.time = step.time;
  keyframe.odometry = policy_.odometry();
  keyframe.observations = std::move(step.observations);
  keyframe.scans = scans_.release();
  keyframe.fixes = fixes_.release();
  keyframe.between = between_.to(step.time, T_start_step_);
  return keyframe;
}

/// Whether a step is a keyframe, whose scans are collected.
bool KeyframeSource::makes_keyframe(const LogStep& step) {
  const bool is_due = policy_.is_keyframe(step);
  collect_scans(step);
  collect_fixes(step);
  collect_poses(step);
  const LaserScan* scan = scans_.newest();
  if (!options_.follows_scans || scan == nullptr) return is_due;
  if (is_due) {
    watch_.begin(*scan);
  } else if (watch_.has_moved(*scan)) {
    policy_.accept(step.time);
    return true;
  }
  return is_due;
}

std::optional<LogStep> KeyframeSource::next_step() {
  if (put_back_) return std::exchange(put_back_, std::nullopt);
  std::optional<LogStep> step = reader_.next();
  if (step && step->odometry) options_.correction.correct(*step->odometry);
  return step;
}

std::optional<Keyframe> KeyframeSource::read() {
  while (std::optional<LogStep> step = next_step()) {
    if (!step->odometry && skipped_) {  // the scans so far have a place, seen from that step
      put_back_ = std::move(step);
      policy_.accept(skipped_->time);
      LogStep last = *std::exchange(skipped_, std::nullopt);
      return make_keyframe(last, {});
    }
    steps_read_ = step->index + 1;
    const bool is_keyframe = makes_keyframe(*step);
    skipped_.reset();
    if (!is_keyframe && (options_.follows_scans || !scans_.empty())) skipped_ = *step;
    if (!is_keyframe && !options_.tracklets) continue;
    Keyframe keyframe;
    for (const auto& observation : step->observations) {
      auto frame = detections_in(*observation, options_.detections, dropped_);
      if (!frame) continue;
      if (frame->time == 0) frame->time = step->time;
      if (const std::size_t repeated = repeated_.remove(*frame)) {
        dropped_["detection dropped: the log has it more than once"] += repeated;
        if (frame->detections.empty()) continue;
      }
      drop_if_unplaced(options_.correction, *frame, dropped_);
      options_.correction.correct(frame->time, *frame);
      hide_ids(options_.correction, options_.detections.robots, *frame);
      auto robots = take_robots(*frame, options_.detections.robots);
      if (robots) keyframe.robots.push_back(std::move(*robots));
      keyframe.detections.push_back(std::move(*frame));
    }
    if (options_.tracklets) track(*step, is_keyframe, keyframe.detections);
    if (is_keyframe) return make_keyframe(*step, std::move(keyframe));
  }
  steps_read_ = options_.steps;
  for (const PoseBetween& entry : reader_.rest()) {
    between_.add(entry.time, T_start_step_ * entry.T_pose_robot);
  }
  if (!skipped_ || !options_.follows_scans) return std::nullopt;
  LogStep last = *std::exchange(skipped_, std::nullopt);
  return make_keyframe(last, {});
}

}  // namespace hybrid
