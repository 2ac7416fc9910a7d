// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/carmen.h"

#include <fmt/format.h>
#include <mrpt/core/bits_math.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/parse_number.h"
#include "mrpt_plugins/import/detail/carmen_lines.h"
#include "mrpt_plugins/import/detail/carmen_odometry.h"
#include "mrpt_plugins/import/detail/carmen_survey.h"
#include "mrpt_plugins/input/odometry_reset.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation2DRangeScan;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

constexpr double kHalfTurn = 180;      // deg
constexpr double kUsualMaxRange = 80;  // m, of the SICK scanners of these logs
constexpr double kMostReach = 1e6;     // m; who says more has no limit

/// One scan of the log.
struct CarmenScan {
  double time = 0;
  std::optional<CPose2D> robot;  // by odometry
  bool asks_odometry = false;    // that of ODOM lines, once they reach its time
  CPose3D sensor;
  double first_deg = -90, step_deg = 1;
  double max_range = kUsualMaxRange;  // 0: no limit
  std::vector<double> ranges;
};

CPose2D pose_in(const TextRow& row, std::size_t at) {
  return {row.coordinate(at), row.coordinate(at + 1), row.number(at + 2)};
}

/// A range up to which a laser sees [m], 0 where that has no limit.
double reach_in(const TextRow& row, std::size_t at) {
  double value = 0;
  if (parse_number(row[at], value) && !(value > 0 && value < kMostReach)) return 0;
  return row.coordinate(at);
}

/// Ranges, with 0 for those that are not finite, as of rays that come back from nothing.
std::vector<double> ranges_of(const TextRow& row, std::size_t begin, std::size_t end) {
  std::vector<double> ranges;
  for (std::size_t i = begin; i < end; ++i) {
    double value = 0;
    const bool is_infinite = parse_number(row[i], value) && !std::isfinite(value);
    ranges.push_back(is_infinite ? 0 : row.number(i));
  }
  return ranges;
}

class CarmenImport {
 public:
  CarmenImport(const CarmenOptions& options, const std::string& output)
      : options_(options), log_(output) {}

  ImportReport run() {
    CarmenLines lines(options_.file);
    const CarmenSurvey survey(lines);
    is_driven_ = survey.has_odometry;
    laser_ = survey.front_laser.place();
    has_corrected_laser_ = !survey.robot_laser.is_fixed();
    if (!survey.has_one_clock()) odometry_.use_no_times();
    TextRow row;
    while (lines.next(row)) {
      log_.used(lines.share());
      if (!take_unless_cut(row, lines)) break;
    }
    add_ready(true);
    if (log_.steps() == 0) {
      throw Error(options_.file +
                  ": no line FLASER, ROBOTLASER1 or RAWLASER1: not a CARMEN log "
                  "with a front laser");
    }
    for (const auto& [word, count] : left_out_) {
      log_.note(fmt::format("{} lines {} left out", count, word));
    }
    if (moves_laser_) {
      log_.note(
          fmt::format("the laser is at x {:.3f} m, y {:.3f} m, yaw {:.3f} rad of the robot, as "
                      "the poses of FLASER lines tell",
                      laser_->x(), laser_->y(), laser_->phi()));
    }
    if (has_corrected_laser_) {
      log_.note(fmt::format(
          "the poses of the laser in ROBOTLASER1 lines are not fixed to those of the robot, as "
          "where they were corrected: the laser is taken to be at x {:.3f} m, y {:.3f} m, yaw "
          "{:.3f} rad of the robot, as PARAM lines tell or else 0",
          offset_, side_offset_, angular_offset_));
    }
    if (!contradiction_.empty()) log_.note(contradiction_);
    if (assumes_angle_) {
      log_.note(
          "the log does not say what angle the rays of FLASER lines cover: 180 degrees taken; "
          "--fov says another");
    }
    if (!lines.is_compressed() && !is_cut_) log_.note_end(options_.file);
    return log_.finish();
  }

 private:
  /// False where the line cannot be read since the file was cut off within it.
  bool take_unless_cut(const TextRow& row, CarmenLines& lines) {
    try {
      take(row);
      return true;
    } catch (const Error&) {
      TextRow other;
      if ((log_.steps() == 0 && waiting_.empty()) || !lines.is_cut() || lines.next(other)) throw;
    }
    is_cut_ = true;
    log_.note(fmt::format("{}: its last line, {}, is cut off: what comes before it is used",
                          options_.file, row.line()));
    return false;
  }

  void take(const TextRow& row) {
    const std::string_view word = row[0];
    if (word == "PARAM") {
      take_parameter(row);
    } else if (word == "ODOM") {
      take_odometry(row);
    } else if (word == "FLASER") {
      take_scan(front_laser(row));
    } else if (word == "ROBOTLASER1") {
      take_scan(robot_laser(row));
    } else if (word == "RAWLASER1") {
      take_scan(raw_laser(row));
    } else if (word == "RLASER" || word == "ROBOTLASER2" || word == "RAWLASER2") {
      ++left_out_[std::string(word)];
    }
  }

  void take_odometry(const TextRow& row) {
    constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
    row.expect(4, kMost, "ODOM x y theta ...");
    double time = 0;
    if (odometry_.has_times()) {
      row.expect(CarmenOdometry::kTime + 1, kMost, "ODOM x y theta tv rv accel time ...");
      time = row.time(CarmenOdometry::kTime);
    }
    odometry_.add(time, pose_in(row, 1));
    add_ready();
  }

  void take_parameter(const TextRow& row) {
    if (row.size() < 3) return;
    if (row[1] == "laser_front_laser_resolution") step_deg_ = row.number(2);
    if (row[1] == "laser_front_laser_fov") {
      const double fov = row.number(2);  // in degrees, or of other writers in radians
      fov_deg_ = fov <= 2 * M_PI ? mrpt::RAD2DEG(fov) : fov;
    }
    if (row[1] == "robot_frontlaser_offset") offset_ = row.coordinate(2);
    if (row[1] == "robot_frontlaser_side_offset") side_offset_ = row.coordinate(2);
    if (row[1] == "robot_frontlaser_angular_offset") angular_offset_ = row.number(2);
    if (row[1] == "robot_front_laser_max") max_range_ = reach_in(row, 2);
  }

  /// Ranges behind their number in word `at`, and the words behind them; `more` words must follow.
  static std::vector<double> ranges_in(const TextRow& row, std::size_t at, std::size_t more) {
    constexpr std::int64_t kMostRays = 100'000;
    if (row.size() <= at) row.fail(row.size(), "the number of ranges is missing");
    const auto count = static_cast<std::size_t>(row.id(at, kMostRays));
    if (row.size() < at + 1 + count + more) {
      row.fail(row.size(), fmt::format("the line ends early: {} ranges and {} words are expected "
                                       "behind their number",
                                       count, more));
    }
    return ranges_of(row, at + 1, at + 1 + count);
  }

  CarmenScan front_laser(const TextRow& row) {
    constexpr std::size_t kMore = 9;  // laser pose, odometry, time, host, time of the logger
    CarmenScan scan;
    scan.ranges = ranges_in(row, 1, kMore);
    const std::size_t behind = 2 + scan.ranges.size();
    scan.robot = pose_in(row, behind + 3);
    scan.time = row.time(behind + 6);
    scan.sensor = CPose3D(front_laser_pose());
    scan.max_range = max_range_ > 0 ? max_range_ : kUsualMaxRange;
    const std::size_t rays = scan.ranges.size();
    scan.step_deg = step_of(rays);
    const std::size_t before_middle = rays / 2;
    scan.first_deg = -scan.step_deg * static_cast<double>(before_middle);
    return scan;
  }

  /// Of PARAM lines. That of a laser which hangs upside down, laser_front_laser_flipped, is not
  /// needed: CARMEN turns its rays round before it publishes them.
  CPose2D stated_pose() const { return {offset_, side_offset_, angular_offset_}; }

  /// As PARAM lines tell it, unless the poses of the lines tell another than these round.
  CPose2D front_laser_pose() {
    const CPose2D stated = stated_pose();
    if (!laser_) return stated;
    const CPose2D off = *laser_ - stated;
    const bool is_same = off.norm() <= kRoundedLength && std::abs(off.phi()) <= kRoundedAngle;
    moves_laser_ = moves_laser_ || !is_same;
    return is_same ? stated : *laser_;
  }

  /// The angle between rays of FLASER lines [deg]. With an even number of rays the last is one step
  /// before the end of the field of view.
  double step_of(std::size_t rays) {
    const std::size_t steps = rays % 2 == 0 ? rays : rays - 1;
    const auto of = [&](double fov) { return steps > 0 ? fov / static_cast<double>(steps) : 0; };
    if (options_.fov_deg > 0) return of(options_.fov_deg);
    if (fov_deg_ <= 0 && step_deg_ <= 0) {
      assumes_angle_ = true;
      return of(kHalfTurn);
    }
    if (fov_deg_ <= 0 || step_deg_ <= 0) return step_deg_ > 0 ? step_deg_ : of(fov_deg_);
    const double told = step_deg_ * static_cast<double>(steps);
    if (std::abs(told - fov_deg_) <= 1.5 * step_deg_ || steps == 0) return step_deg_;
    // Lasers have four, two or one ray a degree: what makes it so is right.
    const double octaves = -std::log2(of(fov_deg_));
    const bool is_usual = octaves > -0.5 && std::abs(octaves - std::round(octaves)) < 0.01;
    contradiction_ = fmt::format(
        "PARAM lines contradict each other: {} rays {} degrees apart cover {:.4g} degrees, and the "
        "field of view is {:.4g}; the {} is taken, --fov says another",
        rays, step_deg_, told, fov_deg_, is_usual ? "latter" : "former");
    return is_usual ? of(fov_deg_) : step_deg_;
  }

  /// Laser type, angles and ranges that ROBOTLASER1 and RAWLASER1 begin with; `behind` becomes the
  /// word behind them.
  static CarmenScan described_laser(const TextRow& row, std::size_t more, std::size_t& behind) {
    constexpr std::size_t kNumberOfRanges = 8;
    CarmenScan scan;
    scan.ranges = ranges_in(row, kNumberOfRanges, 1 + more);
    scan.first_deg = mrpt::RAD2DEG(row.number(2));
    scan.step_deg = mrpt::RAD2DEG(row.number(4));
    scan.max_range = reach_in(row, 5);
    behind = kNumberOfRanges + 1 + scan.ranges.size();
    const std::size_t remissions = ranges_in(row, behind, more).size();
    behind += 1 + remissions;
    return scan;
  }

  CarmenScan robot_laser(const TextRow& row) const {
    constexpr std::size_t kMore = 14;  // two poses, velocities, three distances, times and host
    std::size_t behind = 0;
    CarmenScan scan = described_laser(row, kMore, behind);
    scan.robot = pose_in(row, behind + 3);
    const CPose2D told = pose_in(row, behind) - *scan.robot;
    scan.sensor = CPose3D(has_corrected_laser_ ? stated_pose() : told);
    scan.time = row.time(behind + 11);
    return scan;
  }

  CarmenScan raw_laser(const TextRow& row) const {
    constexpr std::size_t kMore = 3;  // time, host, time of the logger
    std::size_t behind = 0;
    CarmenScan scan = described_laser(row, kMore, behind);
    scan.asks_odometry = is_driven_;
    scan.sensor = CPose3D(stated_pose());
    scan.time = row.time(behind);
    return scan;
  }

  void take_scan(CarmenScan scan) {
    waiting_.push_back(std::move(scan));
    add_ready();
  }

  /// Adds the scans up to the first whose odometry has not come, or all of them.
  void add_ready(bool is_end = false) {
    constexpr std::size_t kMostWaiting = 200;
    for (; !waiting_.empty(); waiting_.pop_front()) {
      CarmenScan& scan = waiting_.front();
      if (!scan.asks_odometry) {
        add(std::move(scan));
        continue;
      }
      const bool may_wait = !is_end && waiting_.size() <= kMostWaiting;
      if (may_wait && !odometry_.reaches(scan.time)) return;
      scan.robot = odometry_.at(scan.time);
      if (scan.robot) {
        add(std::move(scan));
      } else {
        log_.drop("scan dropped: no odometry before it");
      }
    }
  }

  void add(CarmenScan scan) {
    if (options_.max_range > 0) scan.max_range = options_.max_range;
    if (scan.ranges.empty()) {
      log_.drop("scan dropped: no rays");
      return;
    }
    if (last_ && scan.time < last_->first) {
      scan.time = last_->first;
      log_.drop("time stamp repaired: it went backwards, that of the scan before taken");
    }
    ImportedStep step{scan.time, {}, {observation_of(scan)}, {}};
    const bool starts_anew = scan.robot && reset_.at({scan.robot->x(), scan.robot->y(), 0});
    if (starts_anew) {
      log_.drop(OdometryReset::kDropped);
    } else if (last_ && last_->second && scan.robot) {
      step.motion = motion_between(*last_->second, *scan.robot);
    }
    last_ = {scan.time, scan.robot};
    log_.add(step);
  }

  OdometryIncrement motion_between(const CPose2D& from, const CPose2D& to) const {
    const OdometryWalk& walk = options_.walk;
    const CPose2D mean = to - from;
    const Eigen::Vector3d variances = Eigen::Vector3d::Constant(walk.rest * walk.rest) +
                                      walk.variances(mean.norm(), std::abs(mean.phi()));
    return planar_motion(mean.x(), mean.y(), mean.phi(), variances.asDiagonal());
  }

  /// MRPT's scans look straight ahead in the middle: what is not symmetric turns the sensor.
  static CObservation2DRangeScan::Ptr observation_of(const CarmenScan& scan) {
    auto out = CObservation2DRangeScan::Create();
    const std::size_t rays = scan.ranges.size();
    const double opening = scan.step_deg * static_cast<double>(rays - 1);
    const double middle = mrpt::DEG2RAD(scan.first_deg + opening / 2);
    out->sensorLabel = "LASER";
    out->aperture = static_cast<float>(mrpt::DEG2RAD(opening));
    out->maxRange = static_cast<float>(scan.max_range);
    out->sensorPose = scan.sensor + CPose3D(0, 0, 0, middle, 0, 0);
    out->resizeScan(rays);
    for (std::size_t i = 0; i < rays; ++i) {
      const double range = scan.ranges[i];
      out->setScanRange(i, static_cast<float>(range));
      out->setScanRangeValidity(i, range > 0 && (scan.max_range == 0 || range < scan.max_range));
    }
    return out;
  }

  const CarmenOptions& options_;
  LogWriter log_;
  OdometryReset reset_;
  double step_deg_ = 0, fov_deg_ = 0, max_range_ = 0;         // of PARAM lines; 0: not told
  double offset_ = 0, side_offset_ = 0, angular_offset_ = 0;  // of the laser on the robot
  std::optional<CPose2D> laser_;  // on the robot, by the poses of FLASER lines
  bool is_driven_ = false, assumes_angle_ = false, moves_laser_ = false, is_cut_ = false;
  bool has_corrected_laser_ = false;  // its poses in ROBOTLASER1 lines are not of the odometry
  std::string contradiction_;         // of PARAM lines
  CarmenOdometry odometry_;           // of ODOM lines
  std::deque<CarmenScan> waiting_;    // for ODOM lines
  std::optional<std::pair<double, std::optional<CPose2D>>> last_;  // time and robot
  std::map<std::string, std::size_t> left_out_;
};

}  // namespace

ImportReport import_carmen(const CarmenOptions& options, const std::string& output) {
  return CarmenImport(options, output).run();
}

}  // namespace hybrid
