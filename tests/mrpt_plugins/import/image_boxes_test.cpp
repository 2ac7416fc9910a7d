// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cmath>

#include "mrpt_plugins/import/detection_tables.h"
#include "tests/mrpt_plugins/import/import_files.h"

namespace hybrid {
namespace {

class BoxesInImages : public ImportTest {
 protected:
  BoxesInImages() {
    options_.odometry = write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n9,9,0,0\n");
    options_.boxes.focal = 500;
    options_.boxes.image_width = 640;
    options_.boxes.image_height = 480;
    options_.boxes.period = 1;
    std::filesystem::create_directory(at("boxes"));
  }

  /// A file of YOLO; nothing was seen where the text is empty.
  void image(const std::string& name, const std::string& text = "0 0.5 0.5 0.1 0.1 0.9\n") {
    write("boxes/" + name + ".txt", text);
  }
  ImportReport import(const std::string& detections) {
    options_.detections = at(detections);
    return import_detection_tables(options_, log());
  }
  /// Times of the steps of the log, and how much was seen at each.
  std::vector<std::pair<double, std::size_t>> frames() const {
    std::vector<std::pair<double, std::size_t>> out;
    for (const LogStep& step : steps()) out.emplace_back(step.time, seen(step).detections.size());
    return out;
  }

  DetectionTablesOptions options_;
};

using Frames = std::vector<std::pair<double, std::size_t>>;

TEST_F(BoxesInImages, ImagesAreNumberedInFrontOfWhatRoboflowAdds) {
  image("frame_00002_jpg.rf.cf43cd82d8226b6d068f3d15b9fced21");
  image("frame_00003_png.rf.22c799b0726e8182cff9d5287af4d251");
  EXPECT_EQ(import("boxes").steps, 2U);
  EXPECT_EQ(frames(), (Frames{{2, 1}, {3, 1}}));
}

TEST_F(BoxesInImages, NamesMayBeTimes) {
  options_.boxes.period = 0;
  options_.odometry = write("odometry.csv", "time,x,y,yaw\n1700000000,0,0,0\n1700000009,9,0,0\n");
  for (const auto& [a, b] : {std::pair("1700000001.500000", "1700000003.000000"),
                             std::pair("1700000001500", "1700000003000"),
                             std::pair("1700000001500000000", "1700000003000000000")}) {
    image(a);
    image(b);
    EXPECT_EQ(import("boxes").steps, 2U);
    EXPECT_NEAR(steps().at(0).time, 1700000001.5, 1e-5) << a;
    EXPECT_NEAR(steps().at(1).time, 1700000003, 1e-5) << b;
    std::filesystem::remove_all(at("boxes"));
    std::filesystem::create_directory(at("boxes"));
  }
}

TEST_F(BoxesInImages, TimesThatAreCountedAreThoseOfATable) {
  // 3 * 0.2 is 0.6000000000000001.
  const std::string rows = "0.2,0,0,0\n0.4,1,0,0\n0.6,2,0,0\n0.8,3,0,0\n";
  options_.odometry = write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n" + rows);
  options_.boxes.period = 0.2;
  for (const char* name : {"frame_0", "frame_1", "frame_2", "frame_3", "frame_4"}) image(name);
  EXPECT_EQ(import("boxes").steps, 5U);
  for (const LogStep& step : steps()) EXPECT_LE(step.between.size(), 1U) << step.time;
}

TEST_F(BoxesInImages, WhatIsNotOfYoloIsAskedAbout) {
  image("frame_2", "0 320 240 50 60 0.9\n");
  expect_error([&] { import("boxes"); },
               "frame_2.txt:1:3: x = 320 is no share of the image: boxes of YOLO are from 0 to 1; "
               "are these pixels?");
  image("frame_2", "0 0.5 0.5 0.1 0.1 9\n");
  expect_error([&] { import("boxes"); }, "the score 9, which is no probability; is it the id");
  image("frame_2", "0 0.5 0.5 0.1 0.1 1.5\n");
  expect_error([&] { import("boxes"); }, "the score 1.5, which is no probability");
}

TEST_F(BoxesInImages, ImagesWithoutDetectionsAreFrames) {
  image("a2");
  image("a3", "");
  image("a5");
  import("boxes");
  EXPECT_EQ(frames(), (Frames{{2, 1}, {3, 0}, {5, 1}}));
  write("det.txt", "2,-1,100,100,50,200,1\n4,-1,100,100,50,200,1\n99999999,-1,100,100,50,200,1\n");
  import("det.txt");
  EXPECT_EQ(frames(), (Frames{{2, 1}, {3, 0}, {4, 1}})) << "of a video";
}

TEST_F(BoxesInImages, NamesOfTwoCamerasAreNotOneImage) {
  const auto box = [](const char* name) {
    return "{\"image_id\": \"" + std::string(name) +
           "\", \"category_id\": 1, \"bbox\": [100, 100, 50, 50], \"score\": 0.5}";
  };
  write("two.json", "[" + box("left_0002") + "," + box("right_0002") + "]");
  expect_error([&] { import("two.json"); },
               "'left_0002' and 'right_0002' are both of image 2: give one camera at a time");
  write("one.json", "[" + box("left_0002") + "," + box("left_0002") + "]");
  import("one.json");
  EXPECT_EQ(frames(), (Frames{{2, 2}}));
}

TEST_F(BoxesInImages, NumbersFromOneAreToldOf) {
  write("det.txt", "1,-1,100,100,50,200,1\n");
  EXPECT_TRUE(tells(import("det.txt"), "numbered from 1: that one is taken to be of 1 s"));
  write("det.txt", "2,-1,100,100,50,200,1\n");
  EXPECT_FALSE(tells(import("det.txt"), "numbered from 1"));
}

}  // namespace
}  // namespace hybrid
