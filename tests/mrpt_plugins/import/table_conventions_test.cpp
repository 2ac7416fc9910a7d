// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <cmath>

#include "mrpt_plugins/import/detection_tables.h"
#include "mrpt_plugins/input/odometry_gap.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

class TableConventions : public ImportTest {
 protected:
  ImportReport imported(const std::string& odometry, const std::string& detections) {
    DetectionTablesOptions options;
    options.odometry = write("odometry.csv", odometry);
    options.detections = write("detections.csv", detections);
    return import_detection_tables(options, log());
  }
};

const char* const kDetections = "time,range,yaw\n0.5,3,0.1\n1.5,4,-0.2\n";

TEST_F(TableConventions, ColumnsByOtherNamesAndRowNumbers) {
  const ImportReport report = imported("num,t,x,y,theta\n0,0,0,0,0\n1,1,2,0,0\n2,2,2,0,1.5\n",
                                       "seq,timestamp,distance,bearing,label,confidence\n"
                                       "0,0.5,3,0.1,tree,0.8\n1,1.5,4,-0.2,car,0.6\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  const auto& tree = seen(all[0]).detections.at(0);
  EXPECT_NEAR(tree.range, 3, 1e-6);
  EXPECT_NEAR(tree.yaw, 0.1, 1e-6);
  EXPECT_NEAR(tree.class_scores.at(1), 0.8, 1e-6);
  EXPECT_TRUE(tells(report, "column seq is left aside"));
}

TEST_F(TableConventions, MoreNamesOfColumns) {
  const char* odometry = "t,x,y,angle\n0,0,0,0\n2,2,0,1.5\n";
  for (const char* header :
       {"t,dist,azimuth,category,prob", "t,r,angle,name,probability", "t,r,angle,name,conf"}) {
    imported(odometry, std::string(header) + "\n0.5,3,0.1,tree,0.8\n1.5,4,-0.2,car,0.6\n");
    const auto tree = seen(steps().at(0)).detections.at(0);
    EXPECT_NEAR(tree.range, 3, 1e-6);
    EXPECT_NEAR(tree.yaw, 0.1, 1e-6);
    EXPECT_NEAR(tree.class_scores.at(1), 0.8, 1e-6);
    std::filesystem::remove(log());
  }
  for (const char* header : {"t,r,beacon", "t,dist,anchor"}) {
    EXPECT_EQ(imported(odometry, std::string(header) + "\n0.5,3,7\n1.5,2,7\n").detections, 2U);
    std::filesystem::remove(log());
  }
}

TEST_F(TableConventions, AnUnknownColumnIsAskedAbout) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n";
  const auto expect = [&](const char* header, const char* message) {
    expect_error([&] { imported(odometry, std::string(header) + "\n"); }, message);
  };
  expect("time,rnage,yaw", "unknown column 'rnage'; did you mean 'range'? Known are: time range");
  expect("time,range,azimut", "did you mean 'azimuth'?");
  expect("time,range,yaw,temperature", "unknown column 'temperature'; known are: time range");
}

TEST_F(TableConventions, NamesInAnyCaseWithUnitsAndAnIndexWithoutAName) {
  const ImportReport report = imported(
      ",Time [s],X (m),Y,Theta [rad]\n0,0,0,0,0\n1,2,2,0,1.5\n",
      ",Timestamp,Distance,Bearing,Label,Tag_ID\n0,0.5,3,0.1,Tree,7\n1,1.5,4,-0.2,car,8\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  const auto& tree = seen(all[0]).detections.at(0);
  EXPECT_NEAR(tree.range, 3, 1e-6);
  EXPECT_EQ(tree.landmark_id, 7);
  EXPECT_EQ(seen(all[0]).class_names, (std::vector<std::string>{"Tree", "car"}));
  EXPECT_TRUE(tells(report, "column '' is left aside"));
}

TEST_F(TableConventions, TimesThatSeemToBeMillisecondsAreAskedAbout) {
  const std::string odometry = "time,x,y,yaw\n0,0,0,0\n2000,2,0,0\n4000,4,0,0\n";
  const char* asked = "apart: are the times milliseconds?";
  EXPECT_TRUE(tells(imported(odometry, "time,range,yaw\n1000,3,0.1\n1200,4,-0.2\n"), asked));
  std::filesystem::remove(log());
  EXPECT_FALSE(tells(imported(odometry, "time,range,yaw\n1000,3,0.1\n1019,4,-0.2\n"), asked));
  std::filesystem::remove(log());
  const std::string fast = "time,x,y,yaw\n0,0,0,0\n2000,21,0,0\n";
  EXPECT_FALSE(tells(imported(fast, "time,range,yaw\n1000,3,0.1\n1200,4,-0.2\n"), asked));
}

TEST_F(TableConventions, CellsMayBeQuoted) {
  // As R writes them, with a name for each row.
  const ImportReport report =
      imported("\"\",\"time\",\"x\",\"y\",\"yaw\"\n\"1\",0,0,0,0\n\"2\",\"2\",2,0,0\n",
               "\"time\", \"range\",\"Yaw [rad]\",\"class\"\n\"0.5\",\"3\",0.1,\"tree, tall\"\n"
               "1.5,4,-0.2,\"\"\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  EXPECT_NEAR(seen(all[0]).detections.at(0).range, 3, 1e-6);
  EXPECT_EQ(seen(all[0]).class_names, (std::vector<std::string>{"tree, tall"}));
  EXPECT_TRUE(seen(all[1]).detections.at(0).class_scores.empty());
  std::filesystem::remove(log());
  imported("\"time\" \"x\" \"y\" \"yaw\"\n0 0 0 0\n2 2 0 0\n", kDetections);
  EXPECT_EQ(steps().size(), 2U);
  std::filesystem::remove(log());
  expect_error([&] { imported("time,\"x,y,yaw\n0,0,0,0\n", kDetections); }, "unknown column '\"x'");
}

TEST_F(TableConventions, AUnitThatIsAnotherIsRefused) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n2,2,0,0\n";
  for (const char* header :
       {"time,range,yaw [deg]", "time,range,bearing_deg", "time,range,Yaw(Deg)"}) {
    expect_error(
        [&] { imported(odometry, std::string(header) + "\n1,3,20\n"); },
        "detections.csv:1:12: column in deg: times are in seconds, lengths in metres, angles in "
        "radians");
  }
}

TEST_F(TableConventions, PlacesAsTheSensorSeesThem) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n2,2,0,0\n";
  imported(odometry, "time,x,y,class\n0.5,3,4,tree\n1.5,-1,-1,car\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_TRUE(seen(all[0]).has_range);
  EXPECT_FALSE(seen(all[0]).has_pitch);
  EXPECT_NEAR(seen(all[0]).detections.at(0).range, 5, 1e-6);
  EXPECT_NEAR(seen(all[0]).detections.at(0).yaw, std::atan2(4, 3), 1e-6);
  EXPECT_NEAR(seen(all[1]).detections.at(0).yaw, -3 * M_PI / 4, 1e-6);
  std::filesystem::remove(log());
  const ImportReport report = imported(odometry, "time,x,y,z\n0.5,3,4,-5\n0.5,0,0,0\n");
  const auto in_space = steps();
  EXPECT_TRUE(seen(in_space.at(0)).has_pitch);
  EXPECT_NEAR(seen(in_space[0]).detections.at(0).range, std::sqrt(50), 1e-6);
  EXPECT_NEAR(seen(in_space[0]).detections.at(0).pitch, M_PI / 4, 1e-6);  // positive is down
  EXPECT_EQ(report.dropped.at("detection dropped: range not positive"), 1U);
  std::filesystem::remove(log());
  expect_error([&] { imported(odometry, "time,x,y,range\n0.5,3,4,5\n"); },
               "columns x, y beside range or yaw: one or the other");
  expect_error([&] { imported(odometry, "time,x,class\n0.5,3,a\n"); }, "no column 'y'");
  expect_error([&] { imported(odometry, "time,yaw,z\n0.5,3,1\n"); }, "no column 'x'");
}

TEST_F(TableConventions, ATableWithoutARowIsToldAsOne) {
  expect_error([&] { imported("time,x,y,yaw\n0,0,0,0\n2,2,0,0\n", "time,range,yaw\n"); },
               "detections.csv: no detections");
}

TEST_F(TableConventions, QuaternionsInNamedColumns) {
  imported(
      "time,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,2,0,0,0,0,0,1\n"
      "2,2,0,0,0,0,0.70710678,0.70710678\n",
      kDetections);
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_TRUE(all[1].odometry->is_planar);
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-6);
  EXPECT_NEAR(all[1].odometry->mean.yaw(), M_PI / 4, 1e-6);
  DetectionTablesOptions options;
  options.odometry = write("odometry.csv", "time,x,y,qx,qy,qz,qw\n0,0,0,0,0,0,2\n");
  options.detections = write("detections.csv", kDetections);
  std::filesystem::remove(log());
  expect_error([&] { import_detection_tables(options, log()); }, "quaternion of norm 2.000");
}

TEST_F(TableConventions, AQuaternionWithItsRealPartFirstIsAskedAbout) {
  const char* odometry = "0 0 0 0 1 0 0 0\n1 2 0 0 1 0 0 0\n2 2 0 0 0.99 0 0 0.1411\n";
  EXPECT_TRUE(tells(imported(odometry, "time,range,yaw\n0.5,3,0.1\n"), "is qw first?"));
  const char* right = "0 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n2 2 0 0 0 0 0.1411 0.99\n";
  EXPECT_FALSE(tells(imported(right, "time,range,yaw\n0.5,3,0.1\n"), "is qw first?"));
}

TEST_F(TableConventions, RangesWithIdsAloneAreThoseOfBeacons) {
  const ImportReport report =
      imported("time,x,y,yaw\n0,0,0,0\n2,2,0,0\n", "time,range,id\n0.5,3,7\n0.5,4,8\n1.5,2,7\n");
  EXPECT_EQ(report.detections, 3U);
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  const auto* ranges =
      dynamic_cast<const mrpt::obs::CObservationBeaconRanges*>(all[0].observations.at(0).get());
  ASSERT_NE(ranges, nullptr);
  ASSERT_EQ(ranges->sensedData.size(), 2U);
  EXPECT_EQ(ranges->sensedData[1].beaconID, 8);
  EXPECT_NEAR(ranges->sensedData[1].sensedDistance, 4, 1e-6);
  EXPECT_NEAR(ranges->stdError, 0.1, 1e-6);
}

TEST_F(TableConventions, IdsThatAreNamesAreNumberedAndListed) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n2,2,0,0\n";
  const ImportReport report = imported(odometry,
                                       "time,range,yaw,tag,true_id\n0.5,3,0.1,tag36h11:7,door\n"
                                       "0.5,4,0.3,tag36h11:2,tag36h11:7\n0.5,5,0.4,,\n"
                                       "1.5,2,0.1,tag36h11:7,-1\n");
  const auto all = steps();
  const auto& first = seen(all.at(0)).detections;
  EXPECT_EQ(first.at(0).landmark_id, 0);
  EXPECT_EQ(first.at(0).true_landmark_id, 1);
  EXPECT_EQ(first.at(1).landmark_id, 2);
  EXPECT_EQ(first.at(1).true_landmark_id, 0);  // one list for both
  EXPECT_EQ(first.at(2).landmark_id, -1);
  EXPECT_EQ(seen(all.at(1)).detections.at(0).landmark_id, 0);
  EXPECT_EQ(report.files, (std::vector<std::string>{log(), at("out_ids.csv")}));
  EXPECT_EQ(read("out_ids.csv"), "id,name\n0,tag36h11:7\n1,door\n2,tag36h11:2\n");
  EXPECT_TRUE(tells(report, "3 ids are names"));

  imported(odometry, "time,range,yaw,id\n0.5,3,0.1,7\n");
  EXPECT_EQ(seen(steps().at(0)).detections.at(0).landmark_id, 7);
  EXPECT_FALSE(std::filesystem::exists(at("out_ids.csv")));  // of the former log
}

TEST_F(TableConventions, BeaconsWithNames) {
  imported("time,x,y,yaw\n0,0,0,0\n2,2,0,0\n", "time,range,anchor\n0.5,3,east\n1.5,2,west\n");
  const auto all = steps();
  const auto id = [&](std::size_t i) {
    const auto& o = all.at(i).observations.back();
    return dynamic_cast<const mrpt::obs::CObservationBeaconRanges&>(*o).sensedData.at(0).beaconID;
  };
  EXPECT_EQ(id(0), 0);
  EXPECT_EQ(id(1), 1);
}

TEST_F(TableConventions, NumbersAmongNamesAreRefused) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n2,2,0,0\n";
  const auto expect = [&](const char* ids, const char* message) {
    expect_error([&] { imported(odometry, std::string("time,range,yaw,id\n0.5,3,0.1,") + ids); },
                 message);
  };
  expect("door\n0.5,3,0.4,7\n", "detections.csv:3:11: '7' among ids that are names: all are");
  expect("7\n0.5,3,0.4,door\n", "detections.csv:3:11: 'door' among ids that are numbers: all are");
  expect("7x\n", "'7x' is not a number");
}

TEST_F(TableConventions, TimesOfACalendar) {
  imported("time,x,y,yaw\n2024-05-01 11:59:59,0,0,0\n2024-05-01 12:00:01,2,0,0\n",
           "time,range,yaw\n2024-05-01T12:00:00.25Z,3,0.1\n2024-05-01T12:00:00.75Z,3,0.1\n");
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_NEAR(all[0].time, 1714564800.25, 1e-5);
  EXPECT_NEAR(all[1].odometry->mean.x(), 0.5, 1e-6);
}

TEST_F(TableConventions, TimesInSecondsAndNanoseconds) {
  imported("sec,nsec,x,y,yaw\n1714564800,0,0,0,0\n1714564802,0,2,0,0\n",
           "secs,nanosec,range,yaw\n1714564800,250000000,3,0.1\n1714564801,5,3,0.1\n");
  EXPECT_NEAR(steps().at(0).time, 1714564800.25, 1e-6);
  EXPECT_NEAR(steps().at(1).odometry->mean.x(), 0.75, 1e-6);
  std::filesystem::remove(log());
  expect_error([&] { imported("sec,nsec,x,y,yaw\n1,1000000000,0,0,0\n", kDetections); },
               "1000000000' is larger than 999999999");
}

TEST_F(TableConventions, AStampThatIsRepeatedIsNoFault) {
  const std::string table = "time,x,y,yaw\n0,0,0,0\n1,2,0,0\n1,2.02,0,0\n2,4.02,0,0\n";
  const ImportReport report = imported(table, kDetections);
  EXPECT_TRUE(tells(report, "1 rows have the time of the row above"));
  const auto by_table = steps();
  imported("0 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n1 2.02 0 0 0 0 0 1\n2 4.02 0 0 0 0 0 1\n",
           kDetections);
  const auto by_tum = steps();
  ASSERT_EQ(by_table.size(), 2U);
  ASSERT_EQ(by_tum.size(), 2U);
  EXPECT_NEAR(by_table[1].odometry->mean.x(), 2.02, 1e-6);
  EXPECT_NEAR(by_tum[1].odometry->mean.x(), by_table[1].odometry->mean.x(), 1e-9);
}

TEST_F(TableConventions, OdometryThatStartsAnewIsMissingThere) {
  std::string odometry = "time,x,y,yaw\n", detections = "time,range,yaw\n";
  for (int i = 0; i < 100; ++i) {
    odometry += fmt::format("{},{},0,{}\n", i, 0.5 * (i % 60), 0.2 * (i % 60));
    detections += fmt::format("{},3,0\n", i + 0.5);
  }
  const ImportReport report = imported(odometry, detections);
  EXPECT_EQ(
      report.dropped.at("odometry dropped: it starts anew, so that the motion there is not known"),
      1U);
  std::size_t missing = 0;
  for (const LogStep& step : steps()) {
    if (!step.odometry) {
      ++missing;
    } else {
      EXPECT_LT(std::abs(step.odometry->mean.x()), 1.1) << step.index;
    }
  }
  EXPECT_EQ(missing, 2U);  // the first one, and where it starts anew
}

TEST_F(TableConventions, WhatIsSeenWhereOdometryIsMissingIsLeftOut) {
  std::string odometry = "time,x,y,yaw\n", detections = "time,range,yaw\n";
  for (int i = 0; i < 100; ++i) {
    if (i < 40 || i > 60) odometry += fmt::format("{},{},0,0\n", i, 0.5 * i);
    detections += fmt::format("{},3,0\n", i + 0.5);
  }
  const ImportReport report = imported(odometry, detections);
  EXPECT_EQ(report.dropped.at(OdometryGap::kMissing), 1U);
  const auto all = steps();
  ASSERT_EQ(all.size(), 99U - 22U);
  EXPECT_NEAR(all[39].odometry->mean.x(), 11.5, 1e-6);  // what is known across it is used
}

}  // namespace
}  // namespace hybrid
