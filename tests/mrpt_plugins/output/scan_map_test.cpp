// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/scan_map.h"

#include <gtest/gtest.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/scans.h"
#include "mrpt_plugins/output/map_image.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/run_shell.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

constexpr double kSize = 8, kWide = 4;  // m, of a room around the origin

/// What a laser at a place sees of the room.
LaserScan scan_from(double x, double y, double yaw) {
  LaserScan scan;
  constexpr int kRays = 721;
  scan.first_angle = -M_PI;
  scan.angle_step = 2 * M_PI / (kRays - 1);
  scan.T_robot_sensor.translation() = Eigen::Vector3d(0.1, 0, 0.3);
  const Eigen::Vector2d at(x + 0.1 * std::cos(yaw), y + 0.1 * std::sin(yaw));
  for (int i = 0; i < kRays; ++i) {
    const double angle = yaw + scan.first_angle + i * scan.angle_step;
    const double c = std::cos(angle), s = std::sin(angle);
    const double to_x = ((c >= 0 ? kSize / 2 : -kSize / 2) - at.x()) / c;
    const double to_y = ((s >= 0 ? kWide / 2 : -kWide / 2) - at.y()) / s;
    scan.ranges.push_back(static_cast<float>(std::min(to_x, to_y)));
  }
  return scan;
}

/// A robot that crosses the room.
struct Crossing {
  ScanArchive archive;
  Trajectory keyframes;

  Crossing() {
    for (int i = 0; i < 20; ++i) {
      const double x = -2 + 0.25 * i, yaw = 0.1 * i;
      Keyframe keyframe;
      keyframe.scans.push_back(scan_from(x, 0.3, yaw));
      archive.add(static_cast<std::size_t>(i), keyframe);
      const mrpt::poses::CPose3D pose(x, 0.3, 0, yaw, 0, 0);
      keyframes.push_back({static_cast<double>(i), pose});
    }
  }
};

GridMap::Cell at(const GridMap& grid, double x, double y) {
  return grid.at(static_cast<int>((x - grid.corner.x()) / grid.resolution),
                 static_cast<int>((y - grid.corner.y()) / grid.resolution));
}

TEST(ScanMap, AGridHasWallsWhereTheyAre) {
  const Crossing run;
  const auto drawn = drawn_keyframes(run.archive, run.keyframes);
  const GridMap grid = draw_grid(drawn, run.keyframes);
  EXPECT_NEAR(grid.resolution, 0.05, 1e-9);
  EXPECT_GE(grid.width * grid.resolution, kSize);
  int walls = 0, floor = 0;
  for (double x = -3.9; x < 3.9; x += 0.1) {
    for (double y = -1.9; y < 1.9; y += 0.1) floor += at(grid, x, y) == GridMap::kFree ? 1 : 0;
    for (const double y : {-2.0, 2.0}) {
      const bool wall = at(grid, x, y + 0.01) == GridMap::kOccupied ||
                        at(grid, x, y - 0.04) == GridMap::kOccupied;
      walls += wall ? 1 : 0;
    }
  }
  EXPECT_GT(walls, 150) << "of 156";
  EXPECT_GT(floor, 78 * 38 * 0.95);
  EXPECT_EQ(at(grid, 0, 2.3), GridMap::kUnknown);
}

TEST(ScanMap, ARobotThatStandsIsDrawnOnce) {
  ScanArchive archive;
  Trajectory keyframes;
  for (std::size_t i = 0; i < 10; ++i) {
    Keyframe keyframe;
    keyframe.robot = i % 2;
    keyframe.scans = {scan_from(0, 0, 0), scan_from(0, 0, 0)};
    if (i == 4) keyframe.scans.clear();
    archive.add(i, keyframe);
    keyframes.push_back({static_cast<double>(i), i == 8 ? mrpt::poses::CPose3D(0.3, 0, 0, 0, 0, 0)
                                                        : mrpt::poses::CPose3D()});
  }
  const auto drawn = drawn_keyframes(archive, keyframes);
  ASSERT_EQ(drawn.size(), 3U);
  EXPECT_EQ(drawn[0].keyframe, 0U);
  EXPECT_EQ(drawn[1].keyframe, 1U);
  EXPECT_EQ(drawn[2].keyframe, 8U);
  EXPECT_EQ(drawn[0].scans.size(), 2U);
}

TEST(ScanMap, NothingSeenIsNoGrid) {
  ScanArchive archive;
  Keyframe keyframe;
  keyframe.scans.push_back(scan_from(0, 0, 0));
  keyframe.scans[0].ranges.assign(5, std::numeric_limits<float>::quiet_NaN());
  archive.add(0, keyframe);
  const Trajectory keyframes(1);
  EXPECT_TRUE(draw_grid(drawn_keyframes(archive, keyframes), keyframes).empty());
  EXPECT_TRUE(draw_grid({}, {}).empty());
}

TEST(ScanMap, FarPlacesAreDrawnCoarser) {
  ScanArchive archive;
  Trajectory keyframes;
  for (std::size_t i = 0; i < 2; ++i) {
    Keyframe keyframe;
    keyframe.scans.push_back(scan_from(0, 0, 0));
    archive.add(i, keyframe);
    const double far = 200 * static_cast<double>(i);
    keyframes.push_back({static_cast<double>(i), mrpt::poses::CPose3D(far, far, 0, 0, 0, 0)});
  }
  const GridMap grid = draw_grid(drawn_keyframes(archive, keyframes), keyframes, 1e6);
  EXPECT_NEAR(grid.resolution, 0.4, 1e-6);
  EXPECT_EQ(at(grid, 200, 200), GridMap::kFree);
}

TEST(ScanMap, PicturesForRos) {
  GridMap grid;
  grid.corner = {-1.5, 2};
  grid.width = 3;
  grid.height = 2;
  grid.cells = {GridMap::kFree,    GridMap::kOccupied, GridMap::kUnknown,
                GridMap::kUnknown, GridMap::kFree,     GridMap::kFree};
  EXPECT_EQ(grid_pgm(grid), std::string("P5\n3 2\n255\n\xcd\xfe\xfe\xfe\x00\xcd", 17));
  const std::string yaml = grid_yaml(grid, "map.pgm");
  EXPECT_NE(yaml.find("image: map.pgm\n"), std::string::npos);
  EXPECT_NE(yaml.find("resolution: 0.05\n"), std::string::npos);
  EXPECT_NE(yaml.find("origin: [-1.500000, 2.000000, 0.0]\n"), std::string::npos);
}

class ScanMapFile : public ScratchFolder {
 protected:
  /// Writes map.simplemap, map.pgm and map.yaml of a run into the folder.
  void write_maps(const Crossing& run, const std::vector<KeyframeScans>& drawn) const {
    std::vector<Eigen::MatrixXd> covariances(run.keyframes.size());
    covariances[1] = 0.01 * Eigen::Matrix3d::Identity();
    OutputDirectory out(folder);
    write_simple_map(out, "map.simplemap", drawn, run.keyframes, covariances);
    const GridMap grid = draw_grid(drawn, run.keyframes);
    out.write("map.pgm", grid_pgm(grid));
    out.write("map.yaml", grid_yaml(grid, "map.pgm"));
    out.publish({});
  }

  /// Runs a program of MRPT in the folder.
  Ran run(const std::string& command) const {
    return run_shell("cd " + folder.string() + " && " + command + " </dev/null 2>&1");
  }
  static bool is_installed(const std::string& program) {
    return run_shell("command -v " + program).code == 0;
  }

  /// Expects the walls of the room, and nothing inside, in a grid of MRPT's.
  void expect_room(const std::string& name) const {
    mrpt::io::CFileGZInputStream file(at(name));
    mrpt::maps::COccupancyGridMap2D grid;
    mrpt::serialization::archiveFrom(file) >> grid;
    int walls = 0;
    for (float x = -3.9F; x < 3.9F; x += 0.1F) {
      const bool wall = grid.getPos(x, 2.01F) < 0.35F || grid.getPos(x, 1.96F) < 0.35F;
      walls += wall ? 1 : 0;
      EXPECT_GT(grid.getPos(x, 0.5F), 0.6F) << x;
    }
    EXPECT_GT(walls, 72) << "of 78";
  }
};

TEST_F(ScanMapFile, ASimpleMapComesBack) {
  const Crossing run;
  const auto drawn = drawn_keyframes(run.archive, run.keyframes);
  write_maps(run, drawn);
  mrpt::maps::CSimpleMap map;
  ASSERT_TRUE(map.loadFromFile(at("map.simplemap")));
  ASSERT_EQ(map.size(), drawn.size());
  const auto [pose, frame] = map.get(1);
  const auto [covariance, mean] = pose->getCovarianceAndMean();
  EXPECT_NEAR(mean.x(), run.keyframes[1].pose.x(), 1e-9);
  EXPECT_NEAR(covariance(0, 0), 0.01, 1e-9);
  EXPECT_NEAR(covariance(3, 3), 0.01, 1e-9) << "of yaw";
  ASSERT_EQ(frame->size(), 1U);
  DropReport report;
  const auto scan = scan_in(**frame->begin(), {}, report);
  ASSERT_TRUE(scan);
  const LaserScan& before = *drawn[1].scans[0];
  EXPECT_EQ(scan->ranges, before.ranges);
  EXPECT_NEAR(scan->first_angle, before.first_angle, 1e-6);
  EXPECT_TRUE(scan->T_robot_sensor.isApprox(before.T_robot_sensor, 1e-6));
}

TEST_F(ScanMapFile, MrptMakesTheSameMapOfIt) {
  if (!is_installed("observations2map")) GTEST_SKIP() << "observations2map is not installed";
  const Crossing crossing;
  write_maps(crossing, drawn_keyframes(crossing.archive, crossing.keyframes));
  write("map.ini",
        "[MappingApplication]\noccupancyGrid_count=1\nlikelihoodMapSelection=-1\n"
        "[MappingApplication_occupancyGrid_00_creationOpts]\nresolution=0.05\n"
        "[MappingApplication_occupancyGrid_00_insertOpts]\nmaxDistanceInsertion=30\n"
        "considerInvalidRangesAsFreeSpace=0\n");
  const Ran ran = run("observations2map map.ini map.simplemap made");
  EXPECT_NE(ran.text.find("done: 20 observations"), std::string::npos) << ran.text;
  expect_room("made_gridmap_no00.gridmap");
}

TEST_F(ScanMapFile, RosMapsLoadInMrpt) {
  if (!is_installed("ros-map-yaml2mrpt")) GTEST_SKIP() << "ros-map-yaml2mrpt is not installed";
  const Crossing crossing;
  write_maps(crossing, drawn_keyframes(crossing.archive, crossing.keyframes));
  const Ran ran = run("ros-map-yaml2mrpt -i map.yaml");
  EXPECT_EQ(ran.code, 0) << ran.text;
  expect_room("map.gridmap.gz");
}

/// The last "PDF estimation: (x,y,angle deg)" of pf-localization.
std::vector<double> last_estimate(const std::string& text) {
  const std::string mark = "PDF estimation: (";
  const std::size_t at = text.rfind(mark);
  if (at == std::string::npos) return {};
  std::vector<double> numbers;
  std::istringstream in(text.substr(at + mark.size()));
  for (double number = 0; numbers.size() < 3 && in >> number; in.ignore())
    numbers.push_back(number);
  return numbers;
}

TEST_F(ScanMapFile, MrptLocalisesInIt) {
  if (!is_installed("pf-localization")) GTEST_SKIP() << "pf-localization is not installed";
  const Crossing crossing;
  const auto drawn = drawn_keyframes(crossing.archive, crossing.keyframes);
  write_maps(crossing, drawn);
  Objects objects;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const auto& here = crossing.keyframes[i].pose;
    const auto& before = crossing.keyframes[i > 0 ? i - 1 : 0].pose;
    objects.push_back(motion_2d(mrpt::poses::CPose2D(here - before), 0.05));
    objects.push_back(frame({to_mrpt(*drawn[i].scans[0])}));
  }
  write_log(at("drive.rawlog"), objects);
  write("localise.ini",
        "[KLD_options]\nKLD_binSize_PHI_deg=10\nKLD_binSize_XY=0.1\nKLD_delta=0.01\n"
        "KLD_epsilon=0.01\nKLD_maxSampleSize=4000\nKLD_minSampleSize=300\n"
        "KLD_minSamplesPerBin=0\n[PF_options]\nPF_algorithm=0\nresamplingMethod=0\n"
        "adaptiveSampleSize=1\nBETA=0.5\nsampleSize=1\n[LocalizationExperiment]\n"
        "use_3D_poses=false\nmap_file=map.simplemap\nrawlog_file=drive.rawlog\n"
        "logOutput_dir=LOG\n3DSceneFrequency=-1\nexperimentRepetitions=1\n"
        "particles_count=4000\ninit_PDF_mode=0\ninit_PDF_min_x=-3\ninit_PDF_max_x=-1\n"
        "init_PDF_min_y=-1\ninit_PDF_max_y=1.5\nSHOW_PROGRESS_3D_REAL_TIME=false\n"
        "[MetricMap]\noccupancyGrid_count=1\nlikelihoodMapSelection=-1\n"
        "[MetricMap_occupancyGrid_00_creationOpts]\nresolution=0.05\n"
        "[MetricMap_occupancyGrid_00_insertOpts]\nmaxDistanceInsertion=30\n"
        "[MetricMap_occupancyGrid_00_likelihoodOpts]\nlikelihoodMethod=4\nLF_decimation=20\n"
        "LF_stdHit=0.2\nLF_maxCorrsDistance=0.3\nLF_zHit=0.95\nLF_zRandom=0.05\n"
        "LF_maxRange=80\n");
  const Ran ran = run("pf-localization localise.ini");
  const std::vector<double> estimate = last_estimate(ran.text);
  ASSERT_EQ(estimate.size(), 3U) << ran.text;
  const auto& end = crossing.keyframes.back().pose;
  EXPECT_NEAR(estimate[0], end.x(), 0.2);
  EXPECT_NEAR(estimate[1], end.y(), 0.2);
  EXPECT_NEAR(std::remainder(estimate[2] * M_PI / 180 - end.yaw(), 2 * M_PI), 0, 0.1);
}

TEST(ScanMap, TheMapPictureShowsWalls) {
  const Crossing run;
  MapResult result;
  result.trajectory = result.dead_reckoning = run.keyframes;
  const Image without = map_image(result);
  result.grid = std::make_shared<const GridMap>(
      draw_grid(drawn_keyframes(run.archive, run.keyframes), run.keyframes));
  const Image with = map_image(result);
  const auto dark = [](const Image& image) {
    std::size_t count = 0;
    for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
      count += image.rgb[i] == 70 && image.rgb[i + 1] == 70 && image.rgb[i + 2] == 70 ? 1 : 0;
    }
    return count;
  };
  EXPECT_GT(dark(with), dark(without) + 2000);
}

}  // namespace
}  // namespace hybrid
