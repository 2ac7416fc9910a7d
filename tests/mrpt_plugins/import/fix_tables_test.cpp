// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationGPS.h>

#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/import/detection_tables.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationGPS;
using Gga = mrpt::obs::gnss::Message_NMEA_GGA;
using BestPos = mrpt::obs::gnss::Message_NV_OEM6_BESTPOS;

class FixTables : public ImportTest {
 protected:
  /// Straight ahead at 2 m/s, then on a curve.
  DetectionTablesOptions tables(const std::string& fixes) const {
    DetectionTablesOptions options;
    options.odometry = write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n1,2,0,0\n2,2,0,1.5\n");
    options.fixes.table = write("fixes.csv", fixes);
    return options;
  }
  static const CObservationGPS& fix_in(const LogStep& step, std::size_t i = 0) {
    return dynamic_cast<const CObservationGPS&>(*step.observations.at(i));
  }
  static const Gga::content_t& gga(const CObservationGPS& fix) {
    return fix.getMsgByClass<Gga>().fields;
  }
  void expect_fault(const std::string& fixes, const char* part,
                    const std::vector<double>& datum = {}) const {
    DetectionTablesOptions options = tables(fixes);
    options.fixes.datum = datum;
    expect_error([&] { import_detection_tables(options, log()); }, part);
  }
};

TEST_F(FixTables, AloneMakeALogWithAStepEach) {
  DetectionTablesOptions options = tables(
      "Timestamp,Lat [deg],lon,alt,quality\n0.25,-33.885,151.19,31,4\n0.5,-33.884,151.19,32,\n"
      "1.5,-33.883,-179,33,0\n7,0,0,0,1\n");
  options.fixes.antenna = {0.5, -0.25, 1};
  const ImportReport report = import_detection_tables(options, log());
  expect_progress(3);
  EXPECT_EQ(report.dropped.at("fix dropped: no odometry before or after it"), 1U);
  const auto all = steps();
  ASSERT_EQ(all.size(), 3U);
  ASSERT_TRUE(all[1].odometry);
  EXPECT_NEAR(all[1].odometry->mean.x(), 0.5, 1e-9);
  const CObservationGPS& fix = fix_in(all[0]);
  EXPECT_EQ(fix.sensorLabel, "GPS");
  EXPECT_NEAR(mrpt::Clock::toDouble(fix.timestamp), 0.25, 1e-6);
  EXPECT_EQ(fix.sensorPose.z(), 1);
  EXPECT_EQ(gga(fix).latitude_degrees, -33.885);
  EXPECT_EQ(gga(fix).longitude_degrees, 151.19);
  EXPECT_EQ(gga(fix).altitude_meters, 31);
  EXPECT_EQ(gga(fix).geoidal_distance, 0);
  EXPECT_EQ(gga(fix).fix_quality, 4);
  EXPECT_EQ(gga(fix).UTCTime.sec, 0.25);
  EXPECT_EQ(gga(fix).satellitesUsed, 0U);
  EXPECT_FALSE(gga(fix).thereis_HDOP);
  EXPECT_FALSE(fix.hasMsgClass<BestPos>());
  EXPECT_EQ(gga(fix_in(all[1])).fix_quality, 1);
  EXPECT_EQ(gga(fix_in(all[2])).fix_quality, 0);
}

// A circle of 100 s, between the ends of which nothing else is measured.
TEST_F(FixTables, OdometryWandersAlongTheWayBetweenThem) {
  std::string circle = "time,x,y,yaw\n";
  for (int i = 0; i <= 500; ++i) {
    const double angle = 2 * M_PI * i / 500;
    circle += fmt::format("{},{},{},{}\n", 0.2 * i, 10 * std::sin(angle), 10 - 10 * std::cos(angle),
                          std::remainder(angle, 2 * M_PI));
  }
  const std::string row = "-33.885,151.19,31,4\n";
  DetectionTablesOptions options = tables("t,lat,lon,alt,quality\n0," + row + "100," + row);
  options.odometry = write("circle.csv", circle);
  import_detection_tables(options, log());
  const auto ends = steps();
  ASSERT_EQ(ends.size(), 2U);
  ASSERT_TRUE(ends[1].odometry);
  EXPECT_NEAR(ends[1].odometry->mean.norm(), 0, 1e-6);
  // Along the circle of 20 pi m, and for the place the sum of what a turn that is wrong anywhere
  // moves: the mean of squared distances to the start, along each axis.
  const double way = 20 * M_PI, walk = std::pow(options.walk_rotation, 2) * way;
  const Matrix6d& covariance = ends[1].odometry->covariance;
  EXPECT_NEAR(covariance(5, 5), walk, 0.01 * walk);
  const double place = std::pow(options.walk_translation, 2) * way;
  EXPECT_NEAR(covariance(0, 0), place + 150 * walk, 0.02 * (place + 150 * walk));
  EXPECT_NEAR(covariance(1, 1), place + 50 * walk, 0.02 * (place + 50 * walk));
}

TEST_F(FixTables, StandBetweenDetectionsAndWithThem) {
  DetectionTablesOptions options = tables(
      "t,x,y,sigma\n0.25,10,20,0.5\n0.5,11,20,\n0.75,12,20,2\n"
      "1.5,13,20,0.02\n1.5,13,21,0.02\n");
  options.detections = write("detections.csv", "time,range,yaw\n0.5,3,0.1\n0.5,4,0.1\n1,3,0.1\n");
  options.fixes.datum = {-33.885, 151.19, 40};
  const ImportReport report = import_detection_tables(options, log());
  EXPECT_EQ(report.detections, 3U);
  const auto all = steps();
  ASSERT_EQ(all.size(), 5U);  // 0.25, 0.5 of both, 0.75, 1, 1.5
  EXPECT_EQ(seen(all[1]).detections.size(), 2U);
  EXPECT_EQ(fix_in(all[1], 1).sensorLabel, "GPS");
  EXPECT_EQ(seen(all[3]).detections.size(), 1U);
  EXPECT_EQ(all[3].observations.size(), 1U);
  EXPECT_EQ(all[4].observations.size(), 2U);
  double way = 0;
  for (const LogStep& step : all) way += step.odometry ? step.odometry->mean.x() : 0;
  EXPECT_NEAR(way, 1.5, 1e-9);  // from 0.25 s to 1 s
  EXPECT_NEAR(all[4].odometry->mean.yaw(), 0.75, 1e-9);

  const auto& fields = gga(fix_in(all[0]));
  const LocalFrame frame({-33.885, 151.19, 40});
  const Eigen::Vector3d local =
      frame.to_local({fields.latitude_degrees, fields.longitude_degrees, fields.altitude_meters});
  EXPECT_NEAR((local - Eigen::Vector3d(10, 20, 0)).norm(), 0, 1e-7);
  const auto& precise = fix_in(all[0]).getMsgByClass<BestPos>().fields;
  EXPECT_EQ(precise.lat, fields.latitude_degrees);
  EXPECT_EQ(precise.lon, fields.longitude_degrees);
  EXPECT_EQ(precise.hgt, fields.altitude_meters);
  EXPECT_EQ(precise.lat_sigma, 0.5F);
  EXPECT_EQ(precise.lon_sigma, 0.5F);
  EXPECT_EQ(precise.hgt_sigma, 0);
  EXPECT_EQ(precise.position_type, mrpt::obs::gnss::nv_oem6_position_type::SINGLE);
  EXPECT_FALSE(fix_in(all[1], 1).hasMsgClass<BestPos>()) << "the field is empty";
}

TEST_F(FixTables, WithoutADatumAreNoPlacesOnEarth) {
  const DetectionTablesOptions options =
      tables("time,x,y,z\n0,333000.5,6250000,10\n1,333010.5,6250003,11\n");
  const ImportReport report = import_detection_tables(options, log());
  EXPECT_TRUE(
      tells(report, "no --datum: places are relative to the first row, 333000.5 6250000 10 m"));
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(fix_in(all[0]).sensorLabel, "GPS_local");
  EXPECT_EQ(gga(fix_in(all[0])).latitude_degrees, 0);
  EXPECT_EQ(gga(fix_in(all[0])).longitude_degrees, 0);
  const auto& fields = gga(fix_in(all[1]));
  const Eigen::Vector3d local = LocalFrame({0, 0, 0}).to_local(
      {fields.latitude_degrees, fields.longitude_degrees, fields.altitude_meters});
  EXPECT_NEAR((local - Eigen::Vector3d(10, 3, 1)).norm(), 0, 1e-7);
}

TEST_F(FixTables, FaultsAreNamed) {
  expect_fault("time,lat\n0,1\n", "fixes.csv:1:1: no column 'longitude'");
  expect_fault("time,lat,lon,x,y\n0,1,2,3,4\n", "columns x, y beside lat, lon");
  expect_fault("time,lat,lon\n0,91,0\n", "fixes.csv:2:3: latitude 91 is beyond 90 degrees");
  expect_fault("time,lat,lon\n0,9,361\n", "longitude 361 is beyond 360 degrees");
  expect_fault("time,lat [rad],lon\n0,1,0\n", "places on Earth in degrees");
  expect_fault("time,lat,lon\n0,nan,0\n", "'nan' is not a finite number");
  expect_fault("time,lat,lon,alt\n0,1,0,\n", "an empty column; expected a number");
  expect_fault("time,lat,lon\n1,1,0\n0,1,0\n", "fixes.csv:3:1: time goes backwards");
  expect_fault("time,lat,lon,quality\n0,1,0,9\n", "quality 9 is none of GGA");
  expect_fault("time,lat,lon,sigma\n0,1,0,-1\n", "fixes.csv:2:7");
  expect_fault("time,lat,lon\n0,1,0\n", "--datum is for tables with x and y", {0, 0, 0});
  expect_fault("time,x,y\n0,1,0\n", "--datum 100 0 0 is no latitude", {100, 0, 0});
  expect_fault("time,x,y\n0,333000,6250000\n", "6259 km from --datum", {-33, 151, 0});
  expect_fault("time,x,y\n0,0,0\n1,6000000,0\n", "6000 km from that of the first row");
  expect_fault("time,x,y\n70,0,0\n", "no fix has odometry around it: they are of 70 to 70 s");
  expect_fault("time,x,y\n", "no fix");
  DetectionTablesOptions options = tables("time,x,y\n0,0,0\n");
  options.fixes.table.clear();
  expect_error([&] { import_detection_tables(options, log()); },
               "neither --detections nor --fixes");
}

}  // namespace
}  // namespace hybrid
