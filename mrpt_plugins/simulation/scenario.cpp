// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/scenario.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mrpt_plugins/bridge/robot_sections.h"
#include "mrpt_plugins/simulation/robot_path.h"

namespace hybrid {
namespace {

constexpr Interval kCount{1, 100000};
constexpr Interval kFullAngle{0, 360};

std::array<double, 3> triple(IniSection& section, const std::string& key,
                             const std::vector<double>& default_value, const char* meaning) {
  const auto values = section.get(key, default_value, meaning, kCoordinate);
  if (values.size() != 3) section.fail(key, "needs three numbers: x y z");
  return {values[0], values[1], values[2]};
}

Scenario::World read_world(IniFile& ini, bool is_3d) {
  IniSection s = ini.section("world", "Landmarks, placed at random in a box, classes in turn");
  Scenario::World world;
  world.landmarks = s.get("landmarks", 20, "How many; 0 with a [laser] alone", or_zero(kCount));
  world.classes = s.get("classes", std::vector<std::string>{"tree", "car", "pole", "bench"},
                        "Names of the classes");
  world.min_corner = triple(s, "min_corner", {-12, -5, 0}, "Corner of the box, x y z [m]");
  world.max_corner = triple(s, "max_corner", {12, 20, 0}, "Opposite corner [m]");
  world.min_spacing = s.get("min_spacing", 1.0, "Least distance between landmarks [m]", kLength);
  if (world.classes.empty()) s.fail("classes", "needs at least one name");
  for (std::size_t i = 0; i < 3; ++i) {
    if (world.min_corner[i] > world.max_corner[i]) s.fail("max_corner", "is below min_corner");
  }
  if (!is_3d && (world.min_corner[2] != 0 || world.max_corner[2] != 0)) {
    s.fail("max_corner", "and min_corner must have z = 0 in 2d");
  }
  return world;
}

DrivenPath read_path(IniFile& ini) {
  IniSection s = ini.section("path", "Of the robot");
  DrivenPath path;
  const auto start = s.get("start", std::vector<double>{0, 0, 0},
                           "Where it begins in the world, x y yaw [m, deg]", kCoordinate);
  if (start.size() != 3) s.fail("start", "needs three numbers: x y yaw");
  path.start = {start[0], start[1], 0, start[2] * M_PI / 180, 0, 0};
  path.shape = s.choice("shape", "circle", {"circle", "lawnmower", "waypoints"}, "Kind of path");
  path.laps = s.get("laps", 1, "How often it is driven", kCount);
  path.step = s.get("step", 0.5, "Distance between frames [m]", kPositiveLength);
  path.max_turn =
      s.degrees("max_turn_deg", 15, "Turn between frames at a corner [deg]", {0.1, 180});
  path.period = s.get("period", 0.5, "Time between frames [s]", kPositiveDuration);
  path.radius = s.get("radius", 7.5, "Of the circle, driven to the left [m]", kPositiveLength);
  path.width = s.get("width", 20.0, "Length of a lane of the lawnmower [m]", kPositiveLength);
  path.lane_spacing =
      s.get("lane_spacing", 4.0, "Between lanes of the lawnmower [m]", kPositiveLength);
  path.lanes = s.get("lanes", 4, "Of the lawnmower, which then drives back to the start", kCount);
  path.waypoints =
      s.get("waypoints", std::vector<double>{},
            "x y of each waypoint after the start, as seen from there [m]", kCoordinate);
  path.height = s.get("height", 0.0, "In 3d: the path rises and falls from 0 to this height [m]",
                      kCoordinate);
  path.waves = s.get("waves", 2.0, "In 3d: waves of height and roll per path", {0, 1e4});
  path.roll = s.degrees("roll_deg", 0, "In 3d: amplitude of the roll [deg]", {-90, 90});
  if (path.shape == "waypoints" && (path.waypoints.empty() || path.waypoints.size() % 2 != 0)) {
    s.fail("waypoints", "needs pairs of x y");
  }
  return path;
}

Scenario::Odometry read_odometry(IniFile& ini, bool is_3d) {
  IniSection s = ini.section("odometry", "Noise of the motion between two frames");
  Scenario::Odometry odometry;
  odometry.sigma_translation = s.get("sigma_translation", 0.03, "Per axis [m]", kSigmaMetres);
  odometry.sigma_yaw = s.degrees("sigma_yaw_deg", 0.3, "Heading [deg]", kSigmaDegrees);
  odometry.sigma_tilt =
      s.degrees("sigma_tilt_deg", 0.3, "In 3d: pitch and roll [deg]", kSigmaDegrees);
  odometry.scale_translation =
      s.get("scale_translation", 1.0, "Motion per measured translation", {1e-3, 1e3});
  odometry.scale_rotation = s.get("scale_rotation", 1.0, "Turn per measured rotation", {1e-3, 1e3});
  odometry.drift =
      s.degrees("drift_deg_per_m", 0, "Turn per measured metre, unnoticed [deg]", kTurn);
  const bool errs =
      odometry.scale_translation != 1 || odometry.scale_rotation != 1 || odometry.drift != 0;
  if (is_3d && errs) s.fail("scale_translation", "and its like must be left out in 3d");
  return odometry;
}

Scenario::Slip read_slip(IniFile& ini) {
  IniSection s = ini.section("slip", "Wheels that spin at times; adds F_ground_truth_modes.txt");
  Scenario::Slip slip;
  slip.start = s.get("start", 0.0, "Probability per frame that it begins; 0: never", kProbability);
  slip.stay = s.get("stay", 0.8, "Probability per frame that it goes on", kProbability);
  slip.min_share =
      s.get("min_share", 0.2, "Least share of the measured translation that is real", {0.01, 1});
  slip.max_share = s.get("max_share", 0.7, "Largest share", {0.01, 1});
  slip.sigma_yaw =
      s.degrees("sigma_yaw_deg", 2.0, "Noise added to the heading [deg]", or_zero(kSigmaDegrees));
  if (slip.min_share > slip.max_share) s.fail("max_share", "is below min_share");
  return slip;
}

Scenario::Movers read_movers(IniFile& ini) {
  IniSection s = ini.section("movers", "Things that move; adds F_ground_truth_movers.csv");
  Scenario::Movers movers;
  movers.count = s.get("count", 0, "How many", {0, 10000});
  movers.speed = s.get("speed", 1.0, "At first, in a random direction [m/s]", {0, 1e3});
  movers.acceleration =
      s.get("acceleration", 0.2, "By which each component changes within a second [m/s]", {0, 1e3});
  return movers;
}

std::vector<Scenario::Wall> walls_of(IniSection& s, const char* key, const char* meaning) {
  const auto numbers = s.get(key, std::vector<double>{}, meaning, kCoordinate);
  if (numbers.size() % 4 != 0) s.fail(key, "needs four numbers for each: x y x y");
  std::vector<Scenario::Wall> walls;
  for (std::size_t i = 0; i < numbers.size(); i += 4) {
    walls.push_back({numbers[i], numbers[i + 1], numbers[i + 2], numbers[i + 3]});
  }
  return walls;
}

Scenario::Laser read_laser(IniFile& ini, bool is_3d) {
  IniSection s = ini.section(
      "laser", "A planar laser in a floor plan, in 2d: scans beside, or instead of, detections");
  Scenario::Laser laser;
  laser.rays = s.get("rays", 0, "Of a scan; 0: there is no laser", {0, 10000});
  const auto pose =
      s.get("pose", std::vector<double>{0, 0, 0}, "On the robot: x y yaw [m, deg]", kCoordinate);
  if (pose.size() != 3) s.fail("pose", "needs three numbers: x y yaw");
  laser.pose = {pose[0], pose[1], 0, pose[2] * M_PI / 180, 0, 0};
  laser.fov = s.degrees("fov_deg", 180, "From the first ray to the last [deg]", kFullAngle);
  laser.max_range = s.get("max_range", 30.0, "Nothing farther is seen [m]", kPositiveLength);
  laser.sigma_range = s.get("sigma_range", 0.02, "Noise of range [m]", kSigmaMetres);
  laser.walls = walls_of(s, "walls", "x y x y of the ends of each wall, in the world [m]");
  for (const Scenario::Wall& b : walls_of(s, "boxes", "x y x y of opposite corners [m]")) {
    laser.walls.insert(laser.walls.end(), {{b[0], b[1], b[2], b[1]},
                                           {b[2], b[1], b[2], b[3]},
                                           {b[2], b[3], b[0], b[3]},
                                           {b[0], b[3], b[0], b[1]}});
  }
  laser.glass = walls_of(s, "glass", "x y x y of the ends of each pane [m]");
  laser.glass_seen = s.get("glass_seen", 0.2, "That a ray returns from glass", kProbability);
  laser.person_radius =
      s.get("person_radius", 0.25, "Of the discs that [movers] are to the laser [m]", kLength);
  if (laser.rays > 0 && is_3d) s.fail("rays", "must be 0 in 3d");
  return laser;
}

/// The confusion matrix, given in full or by its diagonal with equal other entries.
std::vector<std::vector<double>> read_confusion(IniFile& ini, std::size_t classes) {
  IniSection s = ini.section("detector", "What classes the detector reports");
  const double accuracy = s.get(
      "accuracy", 0.7, "Probability of the right class; others are equally likely", kProbability);
  const auto given = s.get("confusion", std::vector<double>{},
                           "Row by row (true class), the probability of each reported class; "
                           "overrides accuracy",
                           kProbability);
  const double wrong = classes > 1 ? (1 - accuracy) / static_cast<double>(classes - 1) : 0;
  std::vector<std::vector<double>> confusion(classes, std::vector<double>(classes, wrong));
  for (std::size_t i = 0; i < classes; ++i) confusion[i][i] = classes > 1 ? accuracy : 1.0;
  if (given.empty()) return confusion;
  if (given.size() != classes * classes) s.fail("confusion", "needs classes x classes numbers");
  for (std::size_t i = 0; i < classes; ++i) {
    const auto row = given.begin() + static_cast<std::ptrdiff_t>(i * classes);
    confusion[i].assign(row, row + static_cast<std::ptrdiff_t>(classes));
    const double sum = std::accumulate(confusion[i].begin(), confusion[i].end(), 0.0);
    if (std::abs(sum - 1) > 1e-6) s.fail("confusion", "has a row that does not sum to 1");
  }
  return confusion;
}

Scenario::Sensor read_sensor(IniFile& ini, bool is_3d) {
  IniSection s = ini.section("sensor", "Measures range and direction of landmarks");
  Scenario::Sensor sensor;
  const auto pose = s.get("pose", std::vector<double>(6, 0.0),
                          "On the robot: x y z [m] yaw pitch roll [deg]", kCoordinate);
  if (pose.size() != 6) s.fail("pose", "needs six numbers: x y z yaw pitch roll");
  if (!is_3d && (pose[2] != 0 || pose[4] != 0 || pose[5] != 0)) {
    s.fail("pose", "must have z, pitch and roll 0 in 2d");
  }
  constexpr double kDegree = M_PI / 180;
  sensor.pose = {pose[0],           pose[1],           pose[2],
                 pose[3] * kDegree, pose[4] * kDegree, pose[5] * kDegree};
  sensor.min_range = s.get("min_range", 0.5, "Nothing nearer is seen [m]", kLength);
  sensor.max_range = s.get("max_range", 8.0, "Nothing farther is seen [m]", kPositiveLength);
  sensor.fov_yaw = s.degrees("fov_yaw_deg", 180, "Full horizontal view [deg]", kFullAngle);
  sensor.fov_pitch = s.degrees("fov_pitch_deg", 60, "In 3d: full vertical view [deg]", {0, 180});
  sensor.sigma_range = s.get("sigma_range", 0.05, "Noise of range [m]", kSigmaMetres);
  sensor.sigma_yaw = s.degrees("sigma_yaw_deg", 0.5, "Noise of yaw [deg]", kSigmaDegrees);
  sensor.sigma_pitch =
      s.degrees("sigma_pitch_deg", 0.5, "In 3d: noise of pitch [deg]", kSigmaDegrees);
  sensor.detection_probability =
      s.get("detection_probability", 0.95, "That a landmark in view is seen", kProbability);
  sensor.spurious_per_frame =
      s.get("spurious_per_frame", 0.0, "Mean number of detections of nothing", {0, 100});
  sensor.known_ids =
      s.choice("ids", "known", {"known", "hidden"}, "Whether landmarks are identified") == "known";
  sensor.true_ids =
      s.get("store_true_ids", true, "Keep the true ids beside, to evaluate association");
  if (sensor.min_range >= sensor.max_range) s.fail("max_range", "must exceed min_range");
  return sensor;
}

Scenario::Spells read_spells(IniSection& s, const std::string& what, const std::string& words,
                             double shortest, double longest) {
  Scenario::Spells spells;
  spells.every =
      s.get(what + "_every", 0.0,
            "Mean time from the end of " + words + " to the next [s]; 0: none", kDuration);
  spells.shortest = s.get(what + "_min_time", shortest, "Shortest of these [s]", kPositiveDuration);
  spells.longest = s.get(what + "_max_time", longest, "Longest [s]", kPositiveDuration);
  if (spells.shortest > spells.longest) {
    s.fail(what + "_max_time", "is below " + what + "_min_time");
  }
  return spells;
}

void read_fix_errors(IniSection& s, Scenario::Fixes& fixes) {
  fixes.sigma = s.get("sigma", 0.5, "Noise of a single fix, each axis [m]", or_zero(kSigmaMetres));
  fixes.lasting_sigma =
      s.get("lasting_sigma", 1.5, "Of the error that fixes have in common, each axis [m]",
            or_zero(kSigmaMetres));
  fixes.lasts = s.get("lasts", 60.0, "In which that error is forgotten [s]", kPositiveDuration);
  fixes.biased = read_spells(s, "bias", "a run of biased fixes", 5, 60);
  fixes.min_bias =
      s.get("min_bias", 2.0, "Least bias of a run, in a random direction [m]", kLength);
  fixes.max_bias = s.get("max_bias", 30.0, "Largest bias of a run [m]", kLength);
  fixes.bias_walk =
      s.get("bias_walk", 0.0, "By which each axis of a bias changes within a second [m]", kLength);
  fixes.false_share = s.get("false_share", 0.0, "Of fixes that are anywhere", kProbability);
  fixes.false_reach =
      s.get("false_reach", 1000.0, "Side of the square in which these are [m]", kPositiveLength);
  if (fixes.min_bias > fixes.max_bias) s.fail("max_bias", "is below min_bias");
}

Scenario::Fixes read_fixes(IniFile& ini) {
  IniSection s = ini.section("fixes", "A receiver of satellites; adds F_ground_truth_fixes.csv");
  Scenario::Fixes fixes;
  fixes.period =
      s.get("period", 0.0, "Between fixes [s]; 0: there is no receiver", or_zero({1e-3, 1e6}));
  const auto datum = triple(s, "datum", {40, -4, 600},
                            "Latitude, longitude [deg] and altitude [m] of the origin of the "
                            "world, whose x is east");
  if (std::abs(datum[0]) > 90 || std::abs(datum[1]) > 360) {
    s.fail("datum", "has a latitude beyond 90 or a longitude beyond 360 degrees");
  }
  fixes.datum = {datum[0], datum[1], datum[2]};
  fixes.antenna = triple(s, "antenna", {0, 0, 0}, "On the robot, x y z [m]");
  read_fix_errors(s, fixes);
  fixes.outages = read_spells(s, "outage", "a time without fixes", 10, 60);
  fixes.delay = s.get("delay", 0.0, "By which stamps are late [s]", {0, 60});
  fixes.stated_quality =
      s.get("stated_quality", 1, "Of GGA: 1 autonomous, 2 differential, 4 RTK", {0, 8});
  fixes.stated_sigma = s.get("stated_sigma", 0.0,
                             "Of east and north by BESTPOS, which need not be true [m]; 0: none",
                             or_zero(kSigmaMetres));
  return fixes;
}

}  // namespace

Scenario read_scenario(IniFile& ini) {
  IniSection s = ini.section("simulation", "What is written");
  Scenario scenario;
  scenario.seed = s.get("seed", std::uint64_t{1}, "Same seed, same bytes");
  scenario.world_seed = s.get("world_seed", scenario.seed, "The seed of the landmarks alone");
  scenario.is_3d = s.choice("dimension", "2d", {"2d", "3d"}, "Of motion and measurements") == "3d";
  scenario.pairs = s.choice("format", "pairs", {"pairs", "observations"},
                            "Actions and sensory frames, or observations only") == "pairs";
  scenario.classed = s.choice("observation", "classed", {"classed", "plain"},
                              "With class scores, or MRPT's CObservationBearingRange") == "classed";
  if (scenario.is_3d && !scenario.pairs) {
    s.fail("format", "must be 'pairs' in 3d: MRPT has no 3-D odometry observation");
  }
  scenario.world = read_world(ini, scenario.is_3d);
  scenario.path = read_path(ini);
  scenario.odometry = read_odometry(ini, scenario.is_3d);
  scenario.slip = read_slip(ini);
  scenario.movers = read_movers(ini);
  scenario.sensor = read_sensor(ini, scenario.is_3d);
  scenario.laser = read_laser(ini, scenario.is_3d);
  scenario.fixes = read_fixes(ini);
  if (scenario.fixes.period > 0 && !scenario.pairs) {
    s.fail("format", "must be 'pairs' with [fixes], whose times are not those of frames");
  }
  if (scenario.world.landmarks == 0 && scenario.laser.rays == 0 && scenario.fixes.period == 0) {
    ini.section("world").fail("landmarks",
                              "is 0, [laser] rays and [fixes] period too: nothing is seen");
  }
  scenario.sensor.confusion = read_confusion(ini, scenario.world.classes.size());
  return scenario;
}

namespace {

/// One of several robots: its noise is its own, the world is that of all.
NamedScenario read_one(IniFile& ini, IniFile& own, const std::string& name, std::size_t number) {
  IniSection section = ini.section(robot_section(name), "A robot of several in one world");
  const auto id = section.get("id", -101 - static_cast<int>(number),
                              "By which the sensors of other robots know it; not -1", {-2e9, 2e9});
  if (id == -1) section.fail("id", "is the id of nothing");
  IniSection simulation = ini.section("simulation");
  const std::uint64_t seed = simulation.get("seed", std::uint64_t{1}, "Same seed, same bytes");
  own.override_value("simulation", "world_seed", std::to_string(seed), ini.name());
  own.override_value("simulation", "seed", std::to_string(seed + number + 1), ini.name());
  std::vector<std::string> keys = section.keys();
  keys.erase(std::remove(keys.begin(), keys.end(), "id"), keys.end());
  for (const std::string& key : keys) {
    const auto parts = split_key(key);
    if (!parts) section.fail(key, "is neither id nor SECTION.KEY");
    own.override_value(parts->first, parts->second, section.get(key, "", "Instead of that of all"),
                       section.place(key));
  }
  NamedScenario out{name, read_scenario(own)};
  for (const std::string& key : keys) {
    const auto parts = split_key(key);
    if (!own.declares(parts->first, parts->second)) section.fail(key, "is no key of a simulation");
  }
  out.scenario.others.push_back(
      {id, out.scenario.path.period, robot_path(out.scenario.path, out.scenario.is_3d)});
  return out;
}

}  // namespace

std::vector<NamedScenario> read_robots(IniFile& ini,
                                       const std::function<std::unique_ptr<IniFile>()>& fresh) {
  std::vector<NamedScenario> robots;
  for (const std::string& name : robot_names(ini)) {
    const auto own = fresh();
    robots.push_back(read_one(ini, *own, name, robots.size()));
  }
  std::vector<Scenario::Other> all;  // so far each has itself
  for (const NamedScenario& robot : robots) all.push_back(robot.scenario.others.front());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    robots[i].scenario.others = all;
    robots[i].scenario.others.erase(robots[i].scenario.others.begin() +
                                    static_cast<std::ptrdiff_t>(i));
  }
  return robots;
}

}  // namespace hybrid
