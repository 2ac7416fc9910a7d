// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/victoria_park.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/bridge/satellite_fix.h"

namespace hybrid {
namespace {

// Dimensions of the car [m]: wheelbase, distance from the middle of the rear axle to the left wheel
// with the encoder, and position of the laser relative to the middle of the rear axle.
constexpr double kAxles = 2.83, kHalfTrack = 0.76, kLaserAhead = 3.78, kLaserLeft = 0.5;

// Where the local frame of the fixes is put on Earth: about the middle of the park, chosen by us.
constexpr GeodeticPoint kPark{-33.885, 151.190, 0};

constexpr double kRunPause = 1;             // s between runs of fixes, at least
constexpr double kGpsSlack = 1.5;           // m, tolerance of the distance between fixes
constexpr double kReferenceWindow = 0.3;    // m of travel between a sighting and its scan
constexpr double kReferenceDistance = 0.5;  // m between a sighting and its detection

struct Tree {
  double range = 0, bearing = 0;
  std::optional<std::int64_t> id;
};

struct Scan {
  double time = 0;
  double way = 0;  ///< Distance travelled since the start [m].
  OdometryIncrement motion;
  std::vector<Tree> trees;
};

/// The standard car model: speed of the middle of the rear axle, and turn rate.
VelocityOdometry car(const VictoriaParkOptions& options, double scale, double offset) {
  const auto velocity = [=](const TextRow& row) {
    row.expect(3, "time speed steering");
    const double steering = scale * row.coordinate(2) + offset;
    if (std::abs(steering) > 1.2) row.fail(2, "steering angle above 1.2 rad");
    const double curvature = std::tan(steering) / kAxles;
    const double speed = row.coordinate(1) / (1 - kHalfTrack * curvature);
    return Velocity{row.time(0), speed, speed * curvature};
  };
  return {options.folder + "/odometry.txt", velocity, options.walk};
}

std::vector<Scan> read_scans(const VictoriaParkOptions& options, LogWriter& log) {
  std::vector<Scan> scans;
  VelocityOdometry odometry = car(options, options.steering_scale, options.steering_offset);
  VelocityOdometry reference = car(options, 1, 0);  // odometry that the reference used
  TextReader times(options.folder + "/scan_times.txt");
  while (const auto row = times.next()) {
    row->expect(1, "time");
    const double time = row->time(0);
    if (!scans.empty() && time <= scans.back().time) {
      log.drop("scan dropped: not after the one before");
      continue;
    }
    reference.move_to(time);
    scans.push_back({time, reference.way(), odometry.move_to(time), {}});
  }
  TextReader trees(options.folder + "/tree_detections.txt");
  auto scan = scans.begin();
  while (const auto row = trees.next()) {
    row->expect(4, "time range bearing diameter");
    const double time = row->time(0);
    while (scan != scans.end() && scan->time < time - 1e-4) ++scan;
    if (scan == scans.end() || scan->time > time + 1e-4) {
      log.drop("tree dropped: no scan at its time");
      if (scan == scans.end()) scan = scans.begin();
      continue;
    }
    row->coordinate(3);
    scan->trees.push_back({row->coordinate(1), row->coordinate(2) - M_PI_2, {}});
  }
  return scans;
}

/// A sighting of the reference association, at a distance travelled, in the frame of the rear axle.
struct Sighting {
  double way;
  std::int64_t id;
  Eigen::Vector2d point;
};

/// The reference association has poses but no times. Its odometry uses the same car model, so that
/// the distance travelled identifies the scan of a sighting.
std::vector<Sighting> read_reference(const std::string& path) {
  std::vector<Sighting> sightings;
  std::map<std::int64_t, double> way{{0, 0.0}};
  TextReader table(path);
  while (const auto row = table.next()) {
    const bool is_odometry = (*row)[0] == "ODOMETRY";
    if (is_odometry) {
      row->expect(12, "ODOMETRY i j x y angle covariance(6)");
    } else if ((*row)[0] == "LANDMARK") {
      row->expect(8, "LANDMARK i j x y covariance(3)");
    } else {
      row->fail(in_quotes((*row)[0]) + " is neither ODOMETRY nor LANDMARK");
    }
    const std::int64_t from = row->id(1), to = row->id(2);
    const auto start = way.find(from);
    if (start == way.end()) row->fail(1, fmt::format("pose {} has no odometry before", from));
    const Eigen::Vector2d point(row->coordinate(3), row->coordinate(4));
    row->numbers(5, row->size());
    if (is_odometry) {
      way[to] = start->second + point.norm();
    } else {
      sightings.push_back({start->second, to, point});
    }
  }
  return sightings;
}

Eigen::Vector2d point_of(const Tree& tree) {
  return {kLaserAhead + tree.range * std::cos(tree.bearing),
          kLaserLeft + tree.range * std::sin(tree.bearing)};
}

/// Gives the id of each sighting to the nearest detection in the scans at about the same distance
/// travelled.
void give_ids(const std::vector<Sighting>& reference, std::vector<Scan>& scans, LogWriter& log) {
  for (const Sighting& sighting : reference) {
    auto scan = std::lower_bound(scans.begin(), scans.end(), sighting.way - kReferenceWindow,
                                 [](const Scan& s, double way) { return s.way < way; });
    Tree* best = nullptr;
    double nearest = kReferenceDistance;
    for (; scan != scans.end() && scan->way <= sighting.way + kReferenceWindow; ++scan) {
      for (Tree& tree : scan->trees) {
        const double distance = (point_of(tree) - sighting.point).norm();
        if (distance >= nearest) continue;
        nearest = distance;
        best = &tree;
      }
    }
    if (best == nullptr) {
      log.drop("reference sighting dropped: no detection within 0.5 m of it");
    } else if (best->id && *best->id != sighting.id) {
      log.drop("reference sighting dropped: its detection has another id already");
    } else {
      best->id = sighting.id;
    }
  }
}

/// Adds the GPS positions that are consistent with the distance travelled.
void add_gps(const VictoriaParkOptions& options, const std::vector<Scan>& scans, LogWriter& log) {
  TextReader table(options.folder + "/gps.txt");
  std::size_t scan = 0;
  std::optional<Eigen::Vector2d> last;
  double last_time = 0, last_way = 0;
  while (const auto row = table.next()) {
    row->expect(3, "time x y");
    const double time = row->time(0);
    const Eigen::Vector2d position(row->coordinate(1), row->coordinate(2));
    while (scan + 1 < scans.size() && scans[scan + 1].time <= time) ++scan;
    const double way = scans[scan].way;
    if (last && time <= last_time) {
      log.drop("GPS fix dropped: time goes backwards");
    } else if (last && (position - *last).norm() > way - last_way + kGpsSlack) {
      log.drop("GPS fix dropped: farther from the last one than the car drove");
    } else {
      log.true_position(time, {position.x(), position.y(), 0.0});
      last = position;
      last_time = time;
      last_way = way;
    }
  }
}

/// Whether a run of fixes is in the log.
bool is_chosen(const std::string& fixes, std::size_t run) {
  if (fixes == "all") return true;
  return fixes == (run % 2 == 0 ? "even" : "odd");
}

/// The fixes that are in the log, in the order of the file; the others are written beside it.
std::vector<SatelliteFix> read_fixes(const VictoriaParkOptions& options, LogWriter& log) {
  if (options.fixes == "none") return {};
  const LocalFrame park(kPark);
  std::vector<SatelliteFix> fixes;
  TextReader table(options.folder + "/gps.txt");
  std::size_t run = 0;
  std::optional<double> last;
  while (const auto row = table.next()) {
    row->expect(3, "time x y");
    const double time = row->time(0);
    const Eigen::Vector3d position(row->coordinate(1), row->coordinate(2), 0);
    if (last && time - *last > kRunPause) ++run;
    last = time;
    if (is_chosen(options.fixes, run)) {
      fixes.push_back({time, park.to_geodetic(position), 1, 0});
    } else {
      log.held_out_fix(time, position);
    }
  }
  return fixes;
}

}  // namespace

ImportReport import_victoria_park(const VictoriaParkOptions& options, const std::string& output) {
  if (options.fixes != "all" && options.fixes != "even" && options.fixes != "odd" &&
      options.fixes != "none") {
    throw Error("fixes are all, even, odd or none, not " + in_quotes(options.fixes));
  }
  LogWriter log(output);
  std::vector<Scan> scans = read_scans(options, log);
  if (options.reference) {
    const std::string path = options.folder + "/victoria_park_known_assoc_gtsam.txt";
    give_ids(read_reference(path), scans, log);
    log.note_end(path);
  }
  const mrpt::poses::CPose3D T_car_laser(kLaserAhead, kLaserLeft, 0, 0, 0, 0);
  const std::vector<SatelliteFix> fixes = read_fixes(options, log);
  auto fix = fixes.begin();
  for (const Scan& scan : scans) {
    auto frame = planar_detections("LASER", options.detector, T_car_laser);
    frame->fov_yaw = static_cast<float>(M_PI);
    frame->max_range = 80;
    for (const Tree& tree : scan.trees) {
      CObservationClassedBearingRange::Detection d;
      d.range = static_cast<float>(tree.range);
      d.yaw = static_cast<float>(tree.bearing);
      set_noise(options.detector, d);
      if (tree.id) d.landmark_id = static_cast<std::int32_t>(*tree.id);
      frame->detections.push_back(d);
    }
    log.used(static_cast<double>(log.steps() + 1) / static_cast<double>(scans.size()));
    ImportedStep step{scan.time, scan.motion, {frame}, {}};
    const bool is_last = &scan == &scans.back();
    for (; fix != fixes.end() && (is_last || fix->time <= scan.time); ++fix) {
      step.stamped.push_back(satellite_fix(*fix, "GPS", T_car_laser));
    }
    log.add(step);
  }
  add_gps(options, scans, log);
  for (const char* name :
       {"/odometry.txt", "/scan_times.txt", "/tree_detections.txt", "/gps.txt"}) {
    log.note_end(options.folder + name);
  }
  return log.finish();
}

}  // namespace hybrid
