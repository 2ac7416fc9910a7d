// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-import/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>

#include "mrpt_plugins/import/carmen.h"
#include "mrpt_plugins/import/clouds.h"
#include "mrpt_plugins/import/detection_tables.h"
#include "mrpt_plugins/import/kitti.h"
#include "mrpt_plugins/import/kitti_tracking.h"
#include "mrpt_plugins/import/mrclam.h"
#include "mrpt_plugins/import/plaza.h"
#include "mrpt_plugins/import/stata.h"
#include "mrpt_plugins/import/victoria_park.h"
#include "mrpt_plugins/survey/log_survey.h"

namespace hybrid {
namespace {

/// Adds a subcommand, and its options with the same lifetime.
template <class Options, class Import>
std::pair<CLI::App*, Options*> subcommand(CLI::App& app, Convert& convert, const char* name,
                                          const char* about, Import import) {
  auto options = std::make_shared<Options>();
  CLI::App* format = app.add_subcommand(name, about);
  format->option_defaults()->always_capture_default();
  format->callback([options, &convert, import] {
    convert = [options, import](const std::string& output) { return import(*options, output); };
  });
  return {format, options.get()};
}

void add_walk(CLI::App& format, OdometryWalk& walk) {
  format.add_option("--walk-along", walk.along, "odometry noise along [m per sqrt(m)]");
  format.add_option("--walk-across", walk.across, "odometry noise across [m per sqrt(m)]");
  format.add_option("--walk-heading", walk.heading, "of the heading [rad per sqrt(m)]");
  format.add_option("--walk-turning", walk.turning, "of the heading [rad per sqrt(rad turned)]");
}

void add_detector(CLI::App& format, DetectorNoise& noise) {
  format.add_option("--sigma-range", noise.range, "of detections [m]");
  format.add_option("--sigma-range-share", noise.range_share, "of detections [m per m of range]");
  format.add_option("--sigma-bearing", noise.bearing, "of detections [rad]");
  format.add_option("--sigma-across", noise.across,
                    "of the point seen of an object, which near by turns the bearing [m]");
}

void add_noise(CLI::App& format, MotionNoise& noise) {
  format.add_option("--noise-translation", noise.translation,
                    "drawn for each axis of each motion [m]");
  format.add_option("--noise-rotation", noise.rotation, "drawn for each motion [rad]");
  format.add_option("--seed", noise.seed, "of the noise");
}

void add_image_boxes(CLI::App& format, ImageBoxOptions& boxes) {
  const auto add = [&](const char* name, auto& value, const char* about) {
    return format.add_option(name, value, about)->group("Boxes in images (MOT, YOLO, COCO)");
  };
  add("--focal", boxes.focal, "focal length [pixels]");
  add("--center-u", boxes.center_u, "principal point [pixels]; below 0: the middle of the image");
  add("--center-v", boxes.center_v, "principal point [pixels]; below 0: the middle of the image");
  add("--image-width", boxes.image_width, "of the image [pixels]; 0: not known");
  add("--image-height", boxes.image_height, "of the image [pixels]; 0: not known");
  add("--period", boxes.period, "between images [s]");
  add("--start", boxes.start, "time of image 0 [s]");
  add("--frame-times", boxes.frame_times, "a table frame,time in place of both");
  add("--min-score", boxes.min_score, "boxes with less are dropped");
  add("--class-name", boxes.class_names, "NUMBER=NAME of a class; may be given for each")
      ->take_all();
  add("--class-height", boxes.class_heights,
      "NAME=METRES, so that boxes of the class tell a range; may be given for each")
      ->take_all();
  add("--sigma-height", boxes.sigma_height, "of these heights, as a share")
      ->check(CLI::Range(0.0, 1.0));
  add("--sigma-pixels", boxes.sigma_pixels, "of the height of a box [pixels]")
      ->check(CLI::Range(0.0, 1e4));
}

void add_fix_table(CLI::App& format, FixTableOptions& fixes) {
  const auto add = [&](const char* name, auto& value, const char* about) {
    return format.add_option(name, value, about)->group("Satellite fixes");
  };
  add("--fixes", fixes.table,
      "a table: columns time,lat,lon[,alt] [deg, m] or time,x,y[,z] (east north up) [m], then "
      "[,sigma] [m] [,quality] (of GGA: 1 autonomous, 2 differential, 4 RTK fixed, 5 RTK float)");
  add("--datum", fixes.datum,
      "latitude longitude altitude [deg, m] to which x, y, z are relative; without: the first row, "
      "and they are no places on Earth")
      ->expected(3);
  add("--antenna", fixes.antenna, "on the robot: x y z [m]")->expected(3);
}

void note_findings(const LogFindings& findings, std::vector<std::string>& notes) {
  const auto is_measured = [](const NoiseRecord& r) { return r.measured.has_value(); };
  const std::vector<NoiseRecord>& noise = findings.noise;
  if (!noise.empty() && std::none_of(noise.begin(), noise.end(), is_measured)) {
    notes.push_back(fmt::format("noise: not measured, {}", noise.front().why));
  }
  for (const NoiseRecord& record : noise) {
    if (!record.stated || !record.measured || record.unit.empty()) continue;
    notes.push_back(fmt::format(
        "noise of {}: {:.3g} {} stated, {:.3g} +- {:.2g} measured at {:.1f} m", record.kind,
        *record.stated, record.unit, *record.measured, *record.sigma, record.at_range));
  }
  notes.insert(notes.end(), findings.remarks.begin(), findings.remarks.end());
}

/// Converts tables, and notes what the log tells of its noise, as a replay of it will find. The log
/// is complete before it is surveyed: a survey that fails or is stopped is a note as well.
ImportReport import_and_survey(const DetectionTablesOptions& options, const std::string& output) {
  ImportReport report = import_detection_tables(options, output);
  try {
    note_findings(survey_log(output, {}), report.notes);
  } catch (const std::exception& e) {
    report.notes.push_back(fmt::format("noise: not measured, {}", e.what()));
  }
  return report;
}

}  // namespace

CLI::App* add_victoria_park(CLI::App& app, Convert& convert) {
  const auto [format, options] = subcommand<VictoriaParkOptions>(
      app, convert, "victoria-park", "Victoria Park: a car with a laser among trees",
      import_victoria_park);
  format->add_option("folder", options->folder, "Folder of the data set")->required();
  format->add_flag("!--no-reference", options->reference,
                   "do not give detections the ids of the reference association");
  format->add_option("--steering-scale", options->steering_scale, "factor of the steering angle");
  format->add_option("--steering-offset", options->steering_offset, "added to it [rad]");
  format
      ->add_option("--fixes", options->fixes,
                   "which runs of satellite fixes are in the log; of even and odd, the others are "
                   "written beside it")
      ->check(CLI::IsMember({"all", "even", "odd", "none"}));
  add_detector(*format, options->detector);
  add_walk(*format, options->walk);
  return format;
}

CLI::App* add_mrclam(CLI::App& app, Convert& convert) {
  const auto [format, options] = subcommand<MrclamOptions>(
      app, convert, "mrclam", "UTIAS MR.CLAM: one of five robots among barcoded landmarks",
      import_mrclam);
  format->add_option("folder", options->folder, "Folder of the data set")->required();
  format->add_option("--robot", options->robot, "whose log")->check(CLI::Range(1, 5));
  format->add_flag("--keep-robots", options->keep_robots,
                   "keep sightings of other robots, robot N under the id -100 - N");
  format->add_option("--delay", options->delay,
                     "of the camera behind the velocity commands [s]; without: as the log tells");
  add_detector(*format, options->detector);
  add_walk(*format, options->walk);
  return format;
}

CLI::App* add_kitti(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<KittiOptions>(
      app, convert, "kitti",
      "KITTI odometry: visual odometry in the plane or in space, boxes of a detector of cars",
      import_kitti);
  format->add_option("--odometry", o->odometry, "F.g2o: EDGE_SE2 lines; F.txt: 3x4 matrices")
      ->required();
  format->add_option("--covariances", o->covariances, "of the motions of F.txt, 21 numbers a row");
  format->add_option("--inflate", o->inflate, "factor of their standard deviations");
  format
      ->add_option("--boxes", o->boxes,
                   "rows: frame x_min y_min width height coco_class confidence")
      ->required();
  format->add_option("--truth", o->truth, "true poses, 3x4 matrices");
  format->add_option("--period", o->period, "between images [s]");
  format->add_option("--focal", o->focal, "focal length [pixels]");
  format->add_option("--center-u", o->center_u, "principal point [pixels]");
  format->add_option("--center-v", o->center_v, "principal point [pixels]");
  format->add_option("--camera-height", o->camera_height, "above the road [m]");
  format->add_option("--object-height", o->object_height, "of a car [m]");
  format->add_option("--sigma-height", o->sigma_height, "of the height of cars [m]");
  format->add_option("--half-length", o->half_length, "from the side seen to the middle [m]");
  format->add_option("--max-depth", o->max_depth, "boxes farther away are dropped [m]");
  format->add_option("--agreement", o->agreement,
                     "boxes whose depths by height and by road differ by more are dropped");
  format->add_option(
      "--oracle-radius", o->oracle_radius,
      "true ids for sightings that the true poses put within so many metres; 0: none");
  return format;
}

CLI::App* add_kitti_tracking(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<KittiTrackingOptions>(
      app, convert, "kitti-tracking", "KITTI tracking: labelled objects, standing and moving",
      import_kitti_tracking);
  format->add_option("--labels", o->labels, "KITTI's label file")->required();
  format->add_option("--poses", o->poses, "of the camera, 3x4 matrices")->required();
  format->add_option(
      "--pose-scale", o->pose_scale,
      "factor of their translations, where they and the labels disagree in scale; 0: the "
      "one at which what stands is seen in one place");
  add_noise(*format, o->noise);
  format->add_option("--period", o->period, "between frames [s]");
  format->add_option("--max-range", o->max_range, "objects farther away are dropped [m]");
  add_detector(*format, o->detector);
  format->add_option("--still-rms", o->still_rms,
                     "tracks that spread more about their mean move [m]");
  format->add_option("--class-accuracy", o->class_accuracy,
                     "share of detections that keep their class; the others get any");
  return format;
}

CLI::App* add_stata(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<StataOptions>(
      app, convert, "stata", "MIT Stata Center: objects of 8 classes seen by a carried camera",
      import_stata);
  format->add_option("folder", o->folder, "Folder of the data set")->required();
  add_noise(*format, o->noise);
  format->add_option("--period", o->period, "between key-frames [s]");
  add_detector(*format, o->detector);
  format->add_option("--min-score", o->min_score, "detections with less are dropped");
  format->add_option("--oracle-radius", o->oracle_radius,
                     "true ids for sightings of a class that the poses put within so many metres; "
                     "0: none");
  return format;
}

CLI::App* add_plaza(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<PlazaOptions>(
      app, convert, "plaza", "CMU Plaza: ranges to radio beacons, some of unknown identity",
      import_plaza);
  format->add_option("graph", o->graph, "F.fg of NF-iSAM")->required();
  format->add_option("--identities", o->identities, "the graph with all identities, as truth");
  format->add_option("--inflate", o->inflate, "factor of the stated sigmas of x and y of motions");
  format->add_option("--period", o->period, "between poses [s]");
  return format;
}

CLI::App* add_carmen(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<CarmenOptions>(
      app, convert, "carmen", "CARMEN: a robot with a laser range finder, such as those of Radish",
      import_carmen);
  format->add_option("log", o->file, "F.clf, also compressed: .bz2, .gz, .zst")->required();
  format
      ->add_option("--fov", o->fov_deg,
                   "angle that the rays of FLASER lines cover [deg]; 0: as the log says, else 180")
      ->check(CLI::Range(0.0, 360.0));
  format
      ->add_option("--max-range", o->max_range,
                   "at which the sensor sees nothing [m]; 0: as the log says, else 80")
      ->check(CLI::NonNegativeNumber);
  add_walk(*format, o->walk);
  return format;
}

CLI::App* add_clouds(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<CloudsOptions>(
      app, convert, "clouds", "A folder of point clouds of a lidar, or of depth images",
      import_clouds);
  format
      ->add_option("folder", o->folder, "with a file for each: F.bin of KITTI, F.pcd, F.ply, F.png")
      ->required();
  format->add_option(
      "--odometry,--poses", o->odometry,
      "a pose for each cloud, by odometry or another program: rows of TUM, of KITTI, "
      "or 4x4 matrices. Of the sensor, or with --sensor-pose of the robot");
  format->add_option("--truth", o->truth, "true poses, in the same forms");
  format->add_flag("--camera-odometry", o->camera_odometry,
                   "these poses are of a camera that looks along z; of depth images they are");
  format->add_flag("--camera-truth", o->camera_truth,
                   "and so are the true ones, as those of KITTI");
  format->add_option("--period", o->period, "between clouds, where the rows have no times [s]")
      ->check(CLI::PositiveNumber);
  format
      ->add_option("--sensor-pose", o->sensor_pose,
                   "on the robot: x y z yaw pitch roll [m, rad]; poses are then of the robot")
      ->expected(6);
  format->add_option("--most-points", o->most_points,
                     "of a cloud; one with more is thinned to a point a voxel; 0: all");
  format->add_option("--max-range", o->max_range, "points farther away are dropped [m]; 0: none")
      ->check(CLI::NonNegativeNumber);
  format->add_option("--focal", o->focal, "focal length of depth images [pixels]");
  format->add_option("--center-u", o->center_u,
                     "principal point [pixels]; below 0: the middle of the image");
  format->add_option("--center-v", o->center_v,
                     "principal point [pixels]; below 0: the middle of the image");
  format->add_option("--depth-unit", o->depth_unit, "of depth images [m]")
      ->check(CLI::PositiveNumber);
  format->add_option("--walk-translation", o->walk_translation, "odometry noise [m per sqrt(m)]");
  format->add_option("--walk-rotation", o->walk_rotation, "odometry noise [rad per sqrt(m)]");
  return format;
}

CLI::App* add_detection_tables(CLI::App& app, Convert& convert) {
  const auto [format, o] = subcommand<DetectionTablesOptions>(
      app, convert, "csv",
      "Tables of a detector and an odometry of your own; see docs/importing.md", import_and_survey);
  format->add_option("--odometry", o->odometry, "columns time,x,y,yaw or time,x,y,z,yaw,pitch,roll")
      ->required();
  format->add_option(
      "--detections", o->detections,
      "columns time[,range],yaw[,pitch] or time,x,y[,z], then [,class][,score][,id][,true_id]"
      "[,sigma_...]; or "
      "p_NAME for each class instead of class,score. Or boxes in images: a folder of "
      "YOLO, COCO results (F.json), det.txt of MOT. May be left out where there are fixes");
  format->add_option("--classes", o->classes, "names of all classes; default: those met");
  format->add_option("--score", o->score,
                     "probability of the class of a detection where the table has none");
  format->add_option("--sensor-pose", o->sensor_pose, "on the robot: x y z yaw pitch roll [m, rad]")
      ->expected(6);
  format->add_option("--sigma-range", o->sigma_range, "where the table has none [m]");
  format
      ->add_option("--sigma-range-share", o->sigma_range_share,
                   "added to it by root sum of squares [m per m of range]")
      ->check(CLI::Range(0.0, 10.0));
  format->add_option("--sigma-bearing", o->sigma_bearing, "where the table has none [rad]");
  format
      ->add_option("--sigma-across", o->sigma_across,
                   "of the point seen of an object, which near by turns the bearing [m]")
      ->check(CLI::Range(0.0, 1000.0));
  format->add_option("--fov", o->fov, "full opening angle of the detector [rad]; 0: not known");
  format->add_option("--walk-translation", o->walk_translation, "odometry noise [m per sqrt(m)]");
  format->add_option("--walk-rotation", o->walk_rotation, "odometry noise [rad per sqrt(m)]");
  add_fix_table(*format, o->fixes);
  add_image_boxes(*format, o->boxes);
  return format;
}

}  // namespace hybrid
