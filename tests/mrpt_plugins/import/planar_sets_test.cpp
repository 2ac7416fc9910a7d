// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationGPS.h>

#include <cmath>
#include <utility>

#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/import/mrclam.h"
#include "mrpt_plugins/import/plaza.h"
#include "mrpt_plugins/import/victoria_park.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

class PlanarSets : public ImportTest {
 protected:
  /// A car that drives 1 m/s straight ahead past a tree 10 m in front of its laser.
  VictoriaParkOptions victoria() const {
    write("odometry.txt", "# t speed steering\n0 1 0\n5 1 0\n");
    write("scan_times.txt", "0\n1\n2\n");
    write("tree_detections.txt", "0 10 1.5707963 0.3\n1 9 1.5707963 0.3\n2 8 1.5707963 0.3\n");
    write("gps.txt", "0.5 0 0\n1.0 0.5 0\n1.5 40 0\n2.0 1.5 0\n");
    write("victoria_park_known_assoc_gtsam.txt",
          "ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nLANDMARK 1 7 12.78 0.5 1 0 1\n");
    VictoriaParkOptions options;
    options.folder = folder.string();
    options.steering_scale = 1;
    options.steering_offset = 0;
    return options;
  }

  MrclamOptions mrclam() const {
    write("Barcodes.dat", "# subject barcode\n1 5\n2 14\n6 63\n");
    write("Landmark_Groundtruth.dat", "6 2.0 1.0 0.0001 0.0002\n");
    write("Robot1_Odometry.dat", "0 1 0\n10 1 0\n");
    write("Robot1_Groundtruth.dat", "0 0 0 3.1\n4 4 0 -3.1\n");
    write("Robot1_Measurement.dat", "1 63 2.5 0.1\n1 14 1.0 0\n1 99 1 0\n3 63 1.5 0.2\n9 63 1 0\n");
    MrclamOptions options;
    options.folder = folder.string();
    return options;
  }
};

TEST_F(PlanarSets, VictoriaParkFollowsTheCarAndTheReference) {
  const ImportReport report = import_victoria_park(victoria(), log());
  expect_progress(3);
  const auto all = steps();
  ASSERT_EQ(all.size(), 3U);
  ASSERT_TRUE(all[1].odometry && all[2].odometry);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  EXPECT_NEAR(all[1].odometry->covariance(0, 0), 0.05 * 0.05, 1e-6);  // as written, not MRPT's own
  EXPECT_NEAR(all[1].odometry->covariance(5, 5), 0.008 * 0.008, 1e-7);
  const auto& scan = seen(all[1]);
  EXPECT_NEAR(scan.sensor_pose.x(), 3.78, 1e-9);
  EXPECT_NEAR(scan.detections.at(0).yaw, 0, 1e-6);
  EXPECT_EQ(scan.detections[0].landmark_id, 7);  // at 3.78 + 9 m, after 1 m
  EXPECT_EQ(seen(all[0]).detections[0].landmark_id, mrpt::obs::INVALID_LANDMARK_ID);
  EXPECT_EQ(report.dropped.at("GPS fix dropped: farther from the last one than the car drove"), 1U);
  const auto fixes = read_positions(at("out_ground_truth_robot_path.xyz"));
  ASSERT_EQ(fixes.size(), 3U);
  EXPECT_EQ(fixes[2].pose.x(), 1.5);
}

/// The fixes of a frame, and where they are in the local frame of the data set.
std::vector<std::pair<double, Eigen::Vector3d>> fixes_of(const LogStep& step) {
  const LocalFrame park({-33.885, 151.190, 0});
  std::vector<std::pair<double, Eigen::Vector3d>> fixes;
  for (const auto& observation : step.observations) {
    const auto* fix = dynamic_cast<const mrpt::obs::CObservationGPS*>(observation.get());
    if (fix == nullptr) continue;
    EXPECT_EQ(fix->sensorLabel, "GPS");
    EXPECT_EQ(fix->sensorPose.x(), 3.78);
    EXPECT_EQ(fix->sensorPose.y(), 0.5);
    const auto& gga = fix->getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
    EXPECT_EQ(gga.fix_quality, 1);
    fixes.emplace_back(
        mrpt::Clock::toDouble(fix->timestamp),
        park.to_local({gga.latitude_degrees, gga.longitude_degrees, gga.altitude_meters}));
  }
  return fixes;
}

TEST_F(PlanarSets, VictoriaParkHasAllFixesAtTheScanThatIsNotBeforeThem) {
  import_victoria_park(victoria(), log());
  const auto all = steps();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_TRUE(fixes_of(all[0]).empty());
  const auto first = fixes_of(all[1]), second = fixes_of(all[2]);
  ASSERT_EQ(first.size(), 2U);
  ASSERT_EQ(second.size(), 2U);
  EXPECT_EQ(all[1].time, 1);
  EXPECT_NEAR(first[0].first, 0.5, 1e-6);
  EXPECT_NEAR(first[1].first, 1, 1e-6);
  EXPECT_NEAR(second[0].first, 1.5, 1e-6);
  EXPECT_NEAR((second[0].second - Eigen::Vector3d(40, 0, 0)).norm(), 0, 1e-6) << "a bad one too";
}

TEST_F(PlanarSets, VictoriaParkKeepsRunsOfFixesFromTheLog) {
  VictoriaParkOptions options = victoria();
  write("gps.txt", "0.5 0 0\n1.0 0.5 0\n2.5 2 0.25\n4 3 0\n");  // two pauses
  const auto count = [&](const char* which) {
    options.fixes = which;
    import_victoria_park(options, log());
    std::size_t fixes = 0;
    for (const LogStep& step : steps()) fixes += fixes_of(step).size();
    return fixes;
  };
  const std::string held_out = at("out_held_out_fixes.xyz");
  EXPECT_EQ(count("all"), 4U) << "those after the last scan are with it";
  EXPECT_FALSE(std::filesystem::exists(held_out));
  const std::string truth = read("out_ground_truth_robot_path.xyz");
  EXPECT_EQ(count("even"), 3U);
  EXPECT_EQ(read("out_held_out_fixes.xyz"), "% time x y z\n2.500000 2.0000 0.2500 0.0000\n");
  EXPECT_EQ(count("odd"), 1U);
  EXPECT_EQ(read_positions(held_out).size(), 3U);
  EXPECT_EQ(read("out_ground_truth_robot_path.xyz"), truth);
  EXPECT_EQ(count("none"), 0U);
  EXPECT_FALSE(std::filesystem::exists(held_out)) << "of the former log";
  options.fixes = "some";
  std::filesystem::remove(log());
  expect_error([&] { import_victoria_park(options, log()); }, "all, even, odd or none");
}

TEST_F(PlanarSets, VictoriaParkTurnsOnACircle) {
  VictoriaParkOptions options = victoria();
  write("odometry.txt", "0 1 0.3\n20 1 0.3\n");
  import_victoria_park(options, log());
  const double curvature = std::tan(0.3) / 2.83;
  const double way = 1 / (1 - 0.76 * curvature);
  const auto all = steps();
  EXPECT_NEAR(all[1].odometry->mean.yaw(), way * curvature, 1e-6);
  EXPECT_NEAR(all[1].odometry->mean.x(), std::sin(way * curvature) / curvature, 1e-2);
}

TEST_F(PlanarSets, VictoriaParkCorrectsTheSteeringButNotTheWayOfTheReference) {
  VictoriaParkOptions options = victoria();
  write("odometry.txt", "0 1 0.1\n20 1 0.1\n");
  write("victoria_park_known_assoc_gtsam.txt",
        "ODOMETRY 0 1 1.0277 0 0 1 0 0 1 0 1\nLANDMARK 1 7 12.78 0.5 1 0 1\n");
  options.steering_scale = 3;
  options.steering_offset = 0.1;
  import_victoria_park(options, log());
  const auto all = steps();
  const double curvature = std::tan(0.4) / 2.83;
  EXPECT_NEAR(all[1].odometry->mean.yaw(), curvature / (1 - 0.76 * curvature), 1e-6);
  EXPECT_EQ(seen(all[1]).detections.at(0).landmark_id, 7);
}

TEST_F(PlanarSets, MrclamMergesTimesAndDropsRobots) {
  const ImportReport report = import_mrclam(mrclam(), log());
  expect_progress(report.steps);
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(seen(all[0]).detections.size(), 1U);
  EXPECT_EQ(seen(all[0]).detections[0].landmark_id, 6);
  EXPECT_NEAR(seen(all[0]).detections[0].std_range, std::hypot(0.04, 0.04 * 2.5), 1e-6);
  EXPECT_NEAR(seen(all[0]).detections[0].std_yaw, std::hypot(0.009, 0.02 / 2.5), 1e-6);
  EXPECT_NEAR(all[1].odometry->mean.x(), 2, 1e-9);
  EXPECT_EQ(report.dropped.at("detection dropped: another robot"), 1U);
  EXPECT_EQ(report.dropped.at("detection dropped: barcode of nothing listed"), 1U);
  EXPECT_EQ(report.dropped.at("detection dropped: no true pose at its time"), 1U);
  const auto path = read_true_path(at("out_ground_truth_robot_path.txt"));
  ASSERT_EQ(path.size(), 2U);
  EXPECT_NEAR(path[0].x(), 1, 1e-6);
  EXPECT_GT(std::abs(path[0].yaw()), 3.1);  // interpolated across pi, not through zero
  EXPECT_EQ(read_true_landmarks(at("out_ground_truth.txt")).at(0).id, 6);

  MrclamOptions with_robots = mrclam();
  with_robots.keep_robots = true;
  import_mrclam(with_robots, log());
  const auto kept = steps();
  const auto& detections = seen(kept[0]).detections;
  ASSERT_EQ(detections.size(), 2U);
  EXPECT_EQ(std::min(detections[0].landmark_id, detections[1].landmark_id), -102);
}

// Commands to turn to and fro come 0.3 s before the camera shows the turn.
TEST_F(PlanarSets, MrclamCorrectsTheDelayOfTheCamera) {
  MrclamOptions options = mrclam();
  constexpr double kDelay = 0.3, kHold = 2.3, kEnd = 120;  // s
  const auto turn = [](double t) { return std::fmod(t, 2 * kHold) < kHold ? 0.4 : -0.4; };
  std::string commands, truth, measurements;
  double yaw = 0;
  const double step = 0.01;
  for (int i = 0; step * i < kEnd; ++i) {
    const double t = step * i;
    if (i % 10 == 0) commands += std::to_string(t) + " 0 " + std::to_string(turn(t)) + "\n";
    if (i % 50 == 0) truth += std::to_string(t) + " 0 0 " + std::to_string(yaw) + "\n";
    if (i % 25 == 0 && t > 1 && t < kEnd - 2) {
      measurements += std::to_string(t) + " 63 2.5 " + std::to_string(0.5 - yaw) + "\n";
    }
    yaw += step * turn(t - kDelay < 0 ? 0 : t - kDelay);
  }
  write("Robot1_Odometry.dat", commands);
  write("Robot1_Groundtruth.dat", truth);
  write("Robot1_Measurement.dat", measurements);
  // How far what is seen turns otherwise than the odometry tells [rad].
  const auto worst = [&] {
    double error = 0, before = 0;
    const auto all = steps();
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double now = seen(all[i]).detections.at(0).yaw;
      if (i > 0) error = std::max(error, std::abs(before - now - all[i].odometry->mean.yaw()));
      before = now;
    }
    return error;
  };
  const ImportReport report = import_mrclam(options, log());
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_EQ(report.notes[0].rfind("the camera is 0.30", 0), 0U) << report.notes[0];
  EXPECT_LT(worst(), 0.02);
  options.delay = 0;
  EXPECT_TRUE(import_mrclam(options, log()).notes.empty());
  EXPECT_GT(worst(), 0.1);
}

TEST_F(PlanarSets, PlazaKeepsAmbiguousRangesWithoutABeacon) {
  const std::string head =
      "Variable Pose SE2 X0 0 0 0\nVariable Pose SE2 X1 1 0 0\n"
      "Variable Landmark R2 L0 5 5\nVariable Landmark R2 L1 5 -5\n"
      "Factor UnarySE2ApproximateGaussianPriorFactor X0 0 0 0 covariance 1 0 0 0 1 0 0 0 1\n"
      "Factor SE2RelativeGaussianLikelihoodFactor X0 X1 1 0 0.1 covariance .01 0 0 0 .02 0 0 0 "
      ".03\n";
  const std::string known =
      write("known.fg", head + "Factor SE2R2RangeGaussianLikelihoodFactor X1 L1 6.4 0.5\n");
  PlazaOptions options;
  options.graph =
      write("some.fg", head +
                           "Factor AmbiguousDataAssociationFactor Observer X1 Observed "
                           "L0 L1 Weights 0.5 0.5 Binary B Observation 6.4 Sigma 0.5\n");
  options.identities = known;
  import_plaza(options, log());
  expect_progress(2);
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].odometry->covariance(1, 1), 4 * 0.02, 1e-3);
  const auto& ranges =
      dynamic_cast<const mrpt::obs::CObservationBeaconRanges&>(*all[1].observations.at(0));
  ASSERT_EQ(ranges.sensedData.size(), 1U);
  EXPECT_EQ(ranges.sensedData[0].beaconID, mrpt::obs::INVALID_BEACON_ID);
  std::ifstream truth(at("out_ground_truth_associations.csv"));
  std::string header, row;
  std::getline(truth, header);
  std::getline(truth, row);
  EXPECT_EQ(row, "1,0,1");
}

TEST_F(PlanarSets, FaultsAreNamedAndNothingIsWritten) {
  const auto run_victoria = [&] { import_victoria_park({folder.string()}, log()); };
  expect_error(run_victoria, "odometry.txt: no such file");
  victoria();
  write("odometry.txt", "0 1 0\n1 one 0\n");
  expect_error(run_victoria, "odometry.txt:2:3: 'one' is not a number");
  write("odometry.txt", "1 1 0\n0 1 0\n");
  expect_error(run_victoria, "odometry.txt:2:1: time goes backwards");
  MrclamOptions options = mrclam();
  write("Robot1_Measurement.dat", "2 63 1 0\n1 63 1 0\n");
  expect_error([&] { import_mrclam(options, log()); }, "Measurement.dat:2:1: time goes backwards");
  PlazaOptions plaza;
  plaza.graph = write("bad.fg", "Variable Pose SE2 X1 0 0 0\n");
  expect_error([&] { import_plaza(plaza, log()); }, "bad.fg:1:19: poses out of order");
  plaza.graph = write("bad.fg", "Factor Strange X0 X1 1 1 1\n");
  expect_error([&] { import_plaza(plaza, log()); }, "bad.fg:1:8: unknown factor 'Strange'");
}

// A number or a column that is missing would shift the others; ids that do not fit would wrap.
TEST_F(PlanarSets, EveryKindOfRowHasItsOwnLength) {
  const auto expect_reference = [&](const char* row, const char* part) {
    victoria();
    write("victoria_park_known_assoc_gtsam.txt", row);
    expect_error([&] { import_victoria_park({folder.string()}, log()); }, part);
  };
  expect_reference("ODOMETRY 0 1 1 0 0 1 0 0 1 0\n",
                   "gtsam.txt:1:29: 11 columns; expected: ODOMETRY");
  expect_reference("ODOMETRY 0 1 1 0 0 1 0 0 1 0 1\nLANDMARK 1 7 12 0 1 0\n",
                   "gtsam.txt:2:22: 7 columns; expected: LANDMARK");
  expect_reference("ODOMETRY 0 1 1 0 0 1 0 0 1 0 x\n", "gtsam.txt:1:30: 'x' is not a number");
  expect_reference("ODOMETRY 0 4294967297 1 0 0 1 0 0 1 0 1\n", "'4294967297' is larger than");
  const MrclamOptions options = mrclam();
  write("Landmark_Groundtruth.dat", "6 2.0 1.0 0.0001\n");
  expect_error([&] { import_mrclam(options, log()); }, "Groundtruth.dat:1:11: 4 columns");
  write("Landmark_Groundtruth.dat", "6 2.0 1.0\n");
  write("Robot1_Measurement.dat", "1288971999000 63 2.5 0.1\n");
  expect_error([&] { import_mrclam(options, log()); }, "is not a time in seconds");
  PlazaOptions plaza;
  const std::string head = "Variable Pose SE2 X0 0 0 0\nVariable Landmark R2 L0 5 5\n";
  plaza.graph = write("a.fg", head +
                                  "Factor AmbiguousDataAssociationFactor Observer X0 Observed "
                                  "L0 Weights Binary B Observation 6.4 Sigma 0.5\n");
  expect_error([&] { import_plaza(plaza, log()); }, "a.fg:3:1: expected: Factor Ambiguous");
  plaza.graph =
      write("a.fg", head + "Factor SE2R2RangeGaussianLikelihoodFactor X0 L0 6.4 1e-300\n");
  expect_error([&] { import_plaza(plaza, log()); }, "a.fg:3:53: a standard deviation of 1e-300");
}

// Whether its last number is whole, a file whose last line has no end does not say.
TEST_F(PlanarSets, FilesThatEndWithinALineAreNoted) {
  const VictoriaParkOptions options = victoria();
  EXPECT_TRUE(import_victoria_park(options, log()).notes.empty());
  write("gps.txt", "0.5 0 0\n1.0 0.5 0");
  const ImportReport report = import_victoria_park(options, log());
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_EQ(report.notes[0], at("gps.txt") + ": its last line has no end; is the file cut off?");
}

}  // namespace
}  // namespace hybrid
