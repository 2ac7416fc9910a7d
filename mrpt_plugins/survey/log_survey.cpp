// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/log_survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/uncertainty/lasting_ids.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/units.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostSurveyed = 20000, kStretch = 500;  // frames
const double kSame = std::log(1.15);                          // sigmas within that are the same
constexpr double kWorthSaying = 1.5;                          // factor between stated and used
constexpr double kDegree = M_PI / 180;
/// What measures ranges and directions knows them better: a share of the range, radians.
constexpr double kMostNoise = 1.0 / 3;
constexpr const char* kNoSensor =
    "no sensor has such noise: ids, association, mounting or odometry are wrong";

/// Detections of nothing but robots, whose ids last and which move, are left out.
TimedSightings sightings_of(const DetectionFrame& frame, double time,
                            const DetectionOptions& options,
                            std::vector<std::optional<std::int64_t>>& ids) {
  TimedSightings out{frame.time != 0 ? frame.time : time, to_se3(frame.T_robot_sensor), {}};
  const Eigen::Index dim = frame.is_3d ? 3 : 2;
  for (const Detection& d : frame.detections) {
    if (d.id && options.robots.count(*d.id) != 0) continue;
    const Eigen::Vector3d z(d.range, d.yaw, d.pitch);
    out.seen.push_back({z.head(dim), d.covariance.topLeftCorner(dim, dim)});
    ids.push_back(d.id);
  }
  return out;
}

/// The sensor as it is after a correction.
void align_frame(const SensorCorrection& sensor, const std::vector<OdometryPose>& path,
                 MovedSightings& frame) {
  TimedSightings& s = frame.sightings;
  s.T_robot_sensor =
      s.T_robot_sensor * SE3(Eigen::Vector3d::Zero(), SO3::exp(Eigen::Vector3d(0, 0, sensor.yaw)));
  if (sensor.delay != 0) frame.T_odometry_robot = pose_at(path, s.time - sensor.delay);
  for (MeasuredPoint& m : s.seen) {
    m.z[0] *= sensor.length;
    if (sensor.mirrored) m.z[1] = -m.z[1];
  }
}

bool are_the_same(double measured, double stated) {
  return measured > 0 && stated > 0 && std::abs(std::log(measured / stated)) < kSame;
}

/// Whether a measured sigma is better than that of the log. One below that stated is believed where
/// errors do not last, since pairs show what changes alone.
bool is_better(const SensorNoise& noise, const Measured& measured, double stated) {
  if (!measured.replaces(stated)) return false;
  if (noise.is_scaled && are_the_same(measured.value, stated)) return false;
  return noise.is_white() || !(stated > 0) || measured.value > stated;
}

/// Whether the pairs that were measured can be of one thing each.
bool has_credible_range(const SensorNoise& noise) {
  return noise.range.value <= kMostNoise * noise.at_range;
}
bool has_credible_angle(const SensorNoise& noise) {
  return noise.angle.value <= kMostNoise;
}
bool is_credible(const SensorNoise& noise) {
  return has_credible_range(noise) && has_credible_angle(noise);
}

/// One kind, of which `stated` and `measured` are standard deviations.
NoiseRecord record_of(const std::string& sensor, const std::string& kind, const std::string& unit,
                      double stated, const Measured& measured) {
  NoiseRecord out;
  out.sensor = sensor;
  out.kind = kind;
  out.unit = unit;
  out.stated = out.used = stated;
  if (measured.value > 0 && std::isfinite(measured.sigma)) {
    out.measured = measured.value;
    out.sigma = measured.sigma;
  } else {
    out.why = "the log does not tell it";
  }
  return out;
}

std::string digits(double value) {
  return fmt::format("{:.3g}", value);
}

void remark_on(const NoiseRecord& r, const std::string& key, LogFindings& out) {
  if (!r.measured || !r.stated || *r.stated <= 0) return;
  const double apart = std::abs(std::log(r.used / *r.stated));
  const bool used = r.used != *r.stated;
  const bool differs = std::abs(std::log(*r.measured / *r.stated)) > std::log(kWorthSaying) &&
                       std::abs(*r.measured - *r.stated) > 3 * *r.sigma;
  if (apart < std::log(kWorthSaying) && !differs) return;
  const std::string at = r.at_range > 0 ? fmt::format(" at {:.1f} m", r.at_range) : "";
  out.remarks.push_back(fmt::format(
      "noise of {} {}: {}{} stated, {} +- {} measured{}, {} used ({} changes it)", r.sensor, r.kind,
      r.unit.empty() ? "factor " : "", digits(*r.stated) + (r.unit.empty() ? "" : " " + r.unit),
      digits(*r.measured), digits(*r.sigma), at,
      used            ? "measured is"
      : r.why.empty() ? "stated is"
                      : r.why + "; stated is",
      key));
}

std::string name_of(const std::string& label) {
  return label.empty() ? "the sensor" : "sensor " + label;
}

void remark_on(const AlignmentRecord& found, LogFindings& out) {
  const std::string name = name_of(found.sensor);
  if (found.length != 1) {
    out.remarks.push_back(
        fmt::format("ranges of {} fit the odometry when they are multiplied by {:.4g}: one of them "
                    "is in {}? Taken so ([sensor] noise = stated changes it)",
                    name, found.length, length_unit(found.length)));
  }
  if (found.mirrored) {
    out.remarks.push_back(fmt::format(
        "bearings of {} fit with the other sign, by {:.0f} standard deviations: taken so "
        "([sensor] noise = stated changes it)",
        name, found.mirror_sigmas));
  }
  if (found.yaw != 0) {
    out.remarks.push_back(
        fmt::format("{} is turned by {:.1f} +- {:.1f} degrees beside its stated "
                    "pose: corrected ([sensor] noise = stated changes it)",
                    name, found.yaw / kDegree, found.yaw_sigma / kDegree));
  }
  if (found.delay != 0) {
    out.remarks.push_back(
        fmt::format("{} is {:.3f} +- {:.3f} s behind the odometry: corrected "
                    "([sensor] noise = stated changes it)",
                    name, found.delay, found.delay_sigma));
  }
}

std::string model_text(const NoiseModel& model, bool angle) {
  if (model.is_scaled) return fmt::format("{:.4g} x stated", model.factor);
  return fmt::format("hypot({:.4g}, {:.4g} {})", model.constant, model.by_range,
                     angle ? "/ r" : "r");
}

}  // namespace

void LogSurvey::add(const LogStep& step, const std::vector<DetectionFrame>& frames) {
  SE3 pose;
  if (!path_.empty()) pose = path_.back().pose;
  if (step.odometry) {
    if (!path_.empty()) pose = pose * to_se3(step.odometry->mean);
    for (auto& [label, sensor] : sensors_) sensor.since = compose(sensor.since, *step.odometry);
  } else if (!path_.empty()) {
    ++chain_;
  }
  path_.push_back({step.time, pose});
  for (const DetectionFrame& frame : frames) {
    Sensor& sensor = sensors_[frame.sensor_label];
    if (!frame.has_range) sensor.directions_only = true;
    if (!frame.has_range) continue;
    MovedSightings seen = moved(frame, step.time, sensor);
    if (!seen.sightings.seen.empty()) keep(std::move(seen), sensor);
  }
}

/// Keeps a frame if its stretch is one that is kept; of those there are, every other one goes where
/// they are too many.
void LogSurvey::keep(MovedSightings seen, Sensor& sensor) const {
  const std::size_t stretch = sensor.seen++ / kStretch;
  if (stretch % sensor.every != 0) return;
  if (sensor.frames.size() == kMostSurveyed) {
    std::vector<MovedSightings> kept;
    for (std::size_t i = 0; i < sensor.frames.size(); ++i) {
      if (i / kStretch % 2 == 0) kept.push_back(std::move(sensor.frames[i]));
    }
    sensor.frames = std::move(kept);
    sensor.every *= 2;
  }
  sensor.frames.push_back(std::move(seen));
  sensor.since = {};
}

MovedSightings LogSurvey::moved(const DetectionFrame& frame, double time,
                                const Sensor& sensor) const {
  MovedSightings out;
  out.sightings = sightings_of(frame, time, options_.detections, out.ids);
  out.T_odometry_robot = path_.back().pose;
  out.motion_covariance = sensor.since.covariance;
  out.chain = chain_;
  return out;
}

AlignmentRecord LogSurvey::align(const std::string& label, const Sensor& sensor) const {
  std::vector<TimedSightings> sightings;
  for (const MovedSightings& frame : sensor.frames) sightings.push_back(frame.sightings);
  SensorAlignment found = estimate_sensor_alignment(path_, sightings);
  const double length = found.length;
  if (length != 1) {
    for (TimedSightings& frame : sightings) {
      for (MeasuredPoint& seen : frame.seen) seen.z[0] *= length;
    }
    found = estimate_sensor_alignment(path_, sightings);
  }
  return {label,           length,      found.mirrored,    found.mirror_sigmas, found.yaw,
          found.yaw_sigma, found.delay, found.delay_sigma, found.unknown};
}

/// The noise of a sensor that is corrected.
SensorNoise LogSurvey::noise_of(Sensor sensor, const SensorCorrection& correction) const {
  for (std::size_t i = 0; i < sensor.frames.size(); ++i) {
    align_frame(correction, path_, sensor.frames[i]);
    // Stretches that do not follow each other: the motion between them is not known.
    if (sensor.every > 1) sensor.frames[i].chain += static_cast<int>(i / kStretch);
  }
  return measure_sensor_noise(sensor.frames);
}

/// Measures how a sensor stands, and its noise. What it says of the one beside which it has a noise
/// that no sensor has is not believed.
SensorNoise LogSurvey::measure(const std::string& label, const Sensor& sensor,
                               LogFindings& out) const {
  SensorCorrection& correction = out.correction.sensors[label];
  if (!aligns_) return noise_of(sensor, correction);
  AlignmentRecord record = align(label, sensor);
  correction.length = record.length;
  correction.mirrored = record.mirrored;
  correction.yaw = record.yaw;
  correction.delay = record.delay;
  SensorNoise noise = noise_of(sensor, correction);
  if (!is_credible(noise) && !correction.is_none()) {
    correction = {};
    record.length = 1;
    record.mirrored = false;
    record.yaw = record.delay = 0;
    record.unknown = std::string("beside what fits best, ") + kNoSensor;
    out.remarks.push_back("unit, sign, mounting and clock of " + name_of(label) +
                          " stay as stated: " + record.unknown);
    noise = noise_of(sensor, correction);
  }
  remark_on(record, out);
  out.alignment.push_back(std::move(record));
  return noise;
}

void LogSurvey::use(const std::string& label, const SensorNoise& found, LogFindings& out) const {
  SensorCorrection& correction = out.correction.sensors[label];
  NoiseRecord range = record_of(label, "range", "m", found.stated_range, found.range);
  NoiseRecord angle = record_of(label, "angle", "rad", found.stated_angle, found.angle);
  for (NoiseRecord* r : {&range, &angle}) {
    r->at_range = found.at_range;
    if (!found.unknown.empty()) r->why = found.unknown;
    for (const SensorNoise::Lag& lag : found.lags) {
      r->growth.emplace_back(lag.seconds, r == &range ? lag.range : lag.angle);
    }
  }
  if (!has_credible_range(found)) range.why = kNoSensor;
  if (!has_credible_angle(found)) angle.why = kNoSensor;
  if (found.unknown.empty() && is_credible(found)) {
    if (options_.detections.sigma_range <= 0 && is_better(found, found.range, found.stated_range)) {
      correction.range =
          NoiseModel{found.is_scaled, found.range_factor, found.range_m, found.range_share};
      range.used = found.range.value;
      range.model = model_text(*correction.range, false);
    }
    const bool given = options_.detections.sigma_yaw > 0 || options_.detections.sigma_pitch > 0;
    if (!given && is_better(found, found.angle, found.stated_angle)) {
      correction.angle =
          NoiseModel{found.is_scaled, found.angle_factor, found.angle_rad, found.across_m};
      angle.used = found.angle.value;
      angle.model = model_text(*correction.angle, true);
    }
  }
  remark_on(range, "[sensor] sigma_range", out);
  remark_on(angle, "[sensor] sigma_yaw_deg", out);
  out.noise.push_back(std::move(range));
  out.noise.push_back(std::move(angle));
}

void LogSurvey::use_odometry(const std::vector<SensorNoise>& noise, LogFindings& out) const {
  // The sensor that tells it best.
  const auto best = [&](Measured SensorNoise::*kind) {
    Measured least;
    for (const SensorNoise& n : noise) {
      const Measured& m = n.*kind;
      if (!n.is_white() || !is_credible(n) || !(m.value > 0)) continue;
      if (!(least.value > 0) || m.sigma / m.value < least.sigma / least.value) least = m;
    }
    return least;
  };
  const Measured translation = best(&SensorNoise::translation);
  const Measured rotation = best(&SensorNoise::rotation);
  NoiseRecord t = record_of("odometry", "translation", "", 1, translation);
  NoiseRecord r = record_of("odometry", "rotation", "", 1, rotation);
  if (std::none_of(noise.begin(), noise.end(), [](const auto& n) { return n.is_white(); })) {
    t.why = r.why = "errors of the sensors last, or things leave the view too soon to tell";
  }
  if (translation.replaces(1) && !are_the_same(translation.value, 1))
    t.used = out.correction.translation = translation.value;
  if (rotation.replaces(1) && !are_the_same(rotation.value, 1))
    r.used = out.correction.rotation = rotation.value;
  remark_on(t, "[odometry] sigmas", out);
  remark_on(r, "[odometry] sigmas", out);
  out.noise.push_back(std::move(t));
  out.noise.push_back(std::move(r));
}

void LogSurvey::check_ids(LogFindings& out) const {
  if (options_.detections.ids != IdSource::kLog) return;
  IdReturns all;
  for (const auto& [label, sensor] : sensors_) {
    const IdReturns returns = count_id_returns(sensor.frames);
    all.ids += returns.ids;
    all.again += returns.again;
    all.due += returns.due;
    all.returned += returns.returned;
  }
  if (!all.are_of_a_tracker()) {
    for (const auto& [label, sensor] : sensors_) {
      for (const SharedId& shared : shared_ids(sensor.frames)) {
        out.correction.shared_ids.insert(shared.id);
        out.remarks.push_back(fmt::format(
            "id {} is at two places, {:.2g} m apart: two things have it, and its detections are "
            "taken as without one ([sensor] noise = stated keeps it)",
            shared.id, shared.apart));
      }
    }
    return;
  }
  out.correction.hides_ids = true;
  out.remarks.push_back(fmt::format(
      "ids do not return: of {} ids, {} whose places came into view again were not seen "
      "again, and {} were seen once, so they are those of a tracker or of detections and hidden, "
      "as [sensor] ids = none does ([sensor] noise = stated keeps them)",
      all.ids, all.due - all.returned, all.ids - all.again));
}

LogFindings LogSurvey::conclude() const {
  LogFindings out;
  std::vector<SensorNoise> noise;
  bool delayed = false;
  for (const auto& [label, sensor] : sensors_) {
    if (sensor.frames.empty()) {
      if (!sensor.directions_only) continue;
      NoiseRecord angle;
      angle.sensor = label;
      angle.kind = "angle";
      angle.unit = "rad";
      angle.why = "directions without ranges are not measured";
      out.noise.push_back(std::move(angle));
      continue;
    }
    noise.push_back(measure(label, sensor, out));
    use(label, noise.back(), out);
    delayed = delayed || out.correction.sensors[label].delay != 0;
  }
  if (!noise.empty()) use_odometry(noise, out);
  check_ids(out);
  if (delayed) out.correction.path = std::make_shared<const std::vector<OdometryPose>>(path_);
  return out;
}

LogFindings LogSurvey::conclude_ids() const {
  LogFindings out;
  check_ids(out);
  return out;
}

std::vector<AlignmentRecord> LogSurvey::contradictions() const {
  std::vector<AlignmentRecord> out;
  for (const auto& [label, sensor] : sensors_) {
    if (!aligns_ || sensor.frames.empty()) continue;
    AlignmentRecord record = align(label, sensor);
    if (record.mirrored || record.length != 1) out.push_back(std::move(record));
  }
  return out;
}

LogFindings survey_log(const std::string& rawlog, const SourceOptions& options, bool aligns) {
  LogSurvey survey(options, aligns);
  read_contents(rawlog, options,
                [&](const LogStep& step, const std::vector<DetectionFrame>& frames) {
                  survey.add(step, frames);
                });
  return survey.conclude();
}

}  // namespace hybrid
