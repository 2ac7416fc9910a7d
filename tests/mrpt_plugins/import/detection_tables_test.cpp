// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detection_tables.h"

#include <cmath>
#include <filesystem>

#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

class Tables : public ImportTest {
 protected:
  DetectionTablesOptions tables() const {
    DetectionTablesOptions options;
    options.odometry = write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n1,2,0,0\n2,2,0,1.5\n");
    options.detections = write("detections.csv",
                               "time,range,yaw,class,score,id,sigma_range\n"
                               "0.5,3,0.1,tree,0.8,4,\n0.5,0,0.1,tree,0.8,,\n"
                               "1.5,4,-0.2,car,,,0.7\n9,1,0,car,1,,\n");
    return options;
  }
  void expect_table_error(const char* odometry, const char* detections, const char* part) {
    DetectionTablesOptions options = tables();
    write("odometry.csv", odometry);
    write("detections.csv", detections);
    expect_error([&] { import_detection_tables(options, log()); }, part);
  }
};

TEST_F(Tables, InterpolateOdometryAndCountWhatIsLeftOut) {
  const DetectionTablesOptions options = tables();
  const ImportReport report = import_detection_tables(options, log());
  expect_progress(2);
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].time, 0.5);
  ASSERT_TRUE(all[1].odometry);  // from x = 1 to x = 2 and half the turn
  EXPECT_NEAR(all[1].odometry->mean.x(), 1, 1e-9);
  EXPECT_NEAR(all[1].odometry->mean.yaw(), 0.75, 1e-9);
  const auto& tree = seen(all[0]).detections.at(0);
  EXPECT_EQ(tree.landmark_id, 4);
  EXPECT_EQ(seen(all[0]).class_names, (std::vector<std::string>{"car", "tree"}));
  EXPECT_NEAR(tree.class_scores.at(1), 0.8, 1e-6);
  const auto& car = seen(all[1]).detections.at(0);
  EXPECT_EQ(car.landmark_id, mrpt::obs::INVALID_LANDMARK_ID);
  EXPECT_NEAR(car.class_scores.at(0), 1, 1e-6);
  EXPECT_NEAR(car.std_range, 0.7, 1e-6);
  EXPECT_EQ(report.dropped.at("detection dropped: range not positive"), 1U);
  const std::string blank = options.detections + ": ";
  EXPECT_EQ(report.notes,
            (std::vector<std::string>{blank + "3 of 4 fields of column id are blank",
                                      blank + "1 of 4 fields of column score are blank",
                                      blank + "3 of 4 fields of column sigma_range are blank"}));
  EXPECT_EQ(report.dropped.at("detection dropped: no odometry before or after it"), 1U);
}

TEST_F(Tables, ProbabilitiesOfAllClasses) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n1,1,0,0\n";
  expect_table_error(odometry, "time,range,yaw,p_tree\n0,1,0,1.5\n",
                     "detections.csv:2:7: p_tree not within 0 and 1");
  expect_table_error(odometry, "time,range,yaw,class,p_tree\n0,1,0,tree,1\n",
                     "columns p_NAME beside class or score");
  expect_table_error(odometry, "time,range,yaw,p_\n0,1,0,1\n", "unknown column 'p_'");
  expect_table_error("time,x,y,yaw,p_tree\n", "time,range,yaw\n0,1,0\n",
                     "odometry.csv:1:14: unknown column 'p_tree'");
  const DetectionTablesOptions options = tables();
  write("detections.csv", "time,range,yaw,p_tree,p_car\n0.5,3,0.1,0.2,0.7\n1.5,4,0.1,,\n");
  import_detection_tables(options, log());
  const auto all = steps();
  EXPECT_EQ(seen(all[0]).class_names, (std::vector<std::string>{"car", "tree"}));
  const auto& scores = seen(all[0]).detections.at(0).class_scores;
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_NEAR(scores[0], 0.7, 1e-6);
  EXPECT_NEAR(scores[1], 0.2, 1e-6);
  EXPECT_TRUE(seen(all[1]).detections.at(0).class_scores.empty());
}

TEST_F(Tables, ClassesWithoutAScore) {
  DetectionTablesOptions options = tables();
  options.score = 1.5;
  expect_error([&] { import_detection_tables(options, log()); }, "--score must be above 0");
  options.score = 1;
  write("detections.csv", "time,range,yaw,class\n0.5,3,0.1,tree\n1.5,4,0.1,car\n");
  const ImportReport report = import_detection_tables(options, log());
  ASSERT_EQ(report.notes.size(), 1U);
  EXPECT_NE(report.notes[0].find("--score tells how often it is right"), std::string::npos);
  EXPECT_EQ(seen(steps()[0]).detections.at(0).class_scores.at(1), 1);
  options.score = 0.75;
  EXPECT_TRUE(import_detection_tables(options, log()).notes.empty());
  EXPECT_EQ(seen(steps()[0]).detections.at(0).class_scores.at(1), 0.75F);
  EXPECT_EQ(seen(steps()[0]).detections.at(0).class_scores.at(0), 0.25F);
}

TEST_F(Tables, DirectionsAloneAndPosesInSpace) {
  DetectionTablesOptions options = tables();
  write("odometry.csv", "time,x,y,z,yaw,pitch,roll\n0,0,0,0,0,0,0\n2,0,0,4,0,0,0.2\n");
  write("detections.csv", "time,yaw,pitch\n0,0.1,0.2\n1,0.1,0.3\n");
  import_detection_tables(options, log());
  const auto all = steps();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_FALSE(seen(all[0]).has_range);
  EXPECT_TRUE(seen(all[0]).has_pitch);
  EXPECT_NEAR(all[1].odometry->mean.z(), 2, 1e-9);
  EXPECT_NEAR(all[1].odometry->mean.roll(), 0.1, 1e-9);
}

TEST_F(Tables, FaultsAreNamed) {
  const char* odometry = "time,x,y,yaw\n0,0,0,0\n1,1,0,0\n";
  expect_table_error(odometry, "time,range,jaw\n", "detections.csv:1:12: unknown column 'jaw'");
  expect_table_error(odometry, "time,range\n0,1\n", "detections.csv:1:1: no column 'yaw'");
  expect_table_error(odometry, "time,range,yaw\n0,inf,0\n",
                     "detections.csv:2:3: 'inf' is not a finite number");
  expect_table_error(odometry, "time,range,yaw\n0,1\n", "detections.csv:2:4: 2 columns");
  expect_table_error(odometry, "time,range,yaw\n1,1,0\n0,1,0\n", "detections.csv:3:1: time goes");
  expect_table_error(odometry, "time,range,yaw,class,score\n0,1,0,a,2\n",
                     "score not within 0 and 1");
  expect_table_error("time,x,y\n0,0,0\n", "time,range,yaw\n0,1,0\n",
                     "odometry.csv:1:1: no column 'yaw'");
  expect_table_error("time,x,y,yaw\n1,0,0,0\n0,0,0,0\n", "time,range,yaw\n0,1,0\n",
                     "odometry.csv:3:1: time is before");
  expect_table_error(odometry, "time,range,yaw\n0,1,69\n",
                     "detections.csv:2:5: yaw 69 is beyond 2 pi: angles are in radians");
  expect_table_error(odometry, "time;range;yaw\n0;1,5;0\n", "decimals are written with a point");
  expect_table_error(odometry, "time,range,yaw,id\n0,1,0,4294967297\n", "is larger than");
  expect_table_error("time,x,y,yaw\n0,0,0,\n", "time,range,yaw\n0,1,0\n",
                     "odometry.csv:2:7: an empty column; expected a number");
  expect_table_error(odometry, "time,range,yaw\n7,1,0\n", "no detection has odometry around it");
}

TEST_F(Tables, AFaultBehindTheLastDetectionIsNamedToo) {
  expect_table_error("time,x,y,yaw\n0,0,0,0\n1,1,0,0\n2,2,0,0\n3,3,0,0\n4,4,x,0\n",
                     "time,range,yaw\n0.5,1,0\n", "odometry.csv:6:5: 'x'");
}

TEST_F(Tables, BoxesThatAreCutOffAreToldOf) {
  DetectionTablesOptions options = tables();
  options.boxes.focal = 500;
  options.boxes.image_width = 640;
  options.boxes.image_height = 480;
  options.boxes.period = 1;
  const auto notes = [&] {
    return count_notes(import_detection_tables(options, log()), "cut off?");
  };
  options.detections = write("det.txt", "0,1,300,200,20,40,0.9\n1,1,300,200,20,40,0.9\n");
  EXPECT_EQ(notes(), 0);
  write("det.txt", "0,1,300,200,20,40,0.9\n1,1,300,200,20,40,0.");
  EXPECT_EQ(notes(), 1);
  std::filesystem::create_directory(at("yolo"));
  options.detections = at("yolo");
  write("yolo/a_0.txt", "0 0.5 0.4 0.1 0.1 0.9\n");
  write("yolo/a_1.txt", "0 0.5 0.4 0.1 0.1 0.");
  EXPECT_EQ(notes(), 1);
  write("yolo/a_0.txt", "0 0.5 0.4 0.1 0.1 0.9");
  EXPECT_EQ(notes(), 0) << "none has a line end, which many detectors leave out";
}

TEST_F(Tables, ATumTrajectoryIsOdometry) {
  DetectionTablesOptions options = tables();
  import_detection_tables(options, log());
  const auto expected = steps();
  write("odometry.csv",
        "# timestamp tx ty tz qx qy qz qw\n0 0 0 0.1 0 0 0 1\n1 2 0 0.1 0 0 0 1\n"
        "2 2 0 0.1 0 0 0.6816387600233341 0.7316888688738209\n");
  import_detection_tables(options, log());
  const auto all = steps();
  ASSERT_EQ(all.size(), expected.size());
  ASSERT_TRUE(all[1].odometry);
  EXPECT_TRUE(all[1].odometry->is_planar);
  EXPECT_NEAR(all[1].odometry->mean.distanceTo(expected[1].odometry->mean), 0, 1e-9);
  EXPECT_NEAR(all[1].odometry->mean.yaw(), expected[1].odometry->mean.yaw(), 1e-9);
  write("odometry.csv", "0 0 0 0 0 0 0 1\n1 2 0 0.5 0 0 0 1\n2 2 0 1 0 0 0 1\n");
  import_detection_tables(options, log());
  EXPECT_FALSE(steps().at(1).odometry->is_planar);
}

TEST_F(Tables, UsualMistakesAreNamed) {
  const char* seen = "time,range,yaw\n0.5,3,0.1\n";
  const char* path = "time,x,y,yaw\n0,0,0,0\n1,1,0,0\n";
  expect_table_error("time,x,y,yaw\n0,0,0,0\n1,1,0,179\n2,2,0,-179\n", seen,
                     "angles are in radians");
  expect_table_error(path, "time,range,yaw\n0.5,3,45\n", "angles are in radians");
  expect_table_error(path, "0.5,3,0.1\n", "the first row names the columns");
  expect_table_error("0,0,0,0\n1,1,0,0\n", seen, "the first row names the columns");
  expect_table_error(path, "time,range,yaw\n1700000000,3,0.1\n", "times of both are of one clock");
}

}  // namespace
}  // namespace hybrid
