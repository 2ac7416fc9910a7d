// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class ObjectsApp : public ScratchFolder {
 protected:
  ObjectsApp() { fs::create_directories(folder / "table"); }

  /// A camera that moves sideways before a cup 1 m ahead; every third detection is 0.5 m too far.
  /// `identity` is the quaternion of all rotations.
  void write_sequence(bool truth, const std::string& identity = "0 0 0 1") const {
    std::ofstream odometry(folder / "table/odom.txt"), cup(folder / "table/det_cup.txt");
    for (int i = 0; i < 30; ++i) {
      const double t = 0.1 * i, x = 0.01 * i, y = 0.001 * i * i;
      odometry << t << " " << x << " " << y << " 0 " << identity << "\n";
      cup << t << " " << -x << " " << -y << (i % 3 == 2 ? " 1.5 " : " 1 ") << identity << "\n";
    }
    odometry.close();
    cup.close();
    if (!truth) return;
    fs::copy(folder / "table/odom.txt", folder / "table/cam_gt.txt");
    fs::copy(folder / "table/det_cup.txt", folder / "table/objgt_cup.txt");
  }
  int run(const std::string& sequences) {
    const Ran ran = run_app("hybrid-objects " + sequences + " -o " + at("out"));
    text_ = ran.text;
    return ran.code;
  }

  std::string text_;
};

TEST_F(ObjectsApp, WritesObjectsTrajectorySummaryAndPicture) {
  write_sequence(true);
  ASSERT_EQ(run((folder / "table/").string()), 0) << text_;
  for (const char* name : {"objects.csv", "trajectory.tum", "objects.png"}) {
    EXPECT_GT(fs::file_size(folder / "out/table" / name), 0u) << name;
  }
  std::ifstream file(folder / "out/summary.json");
  const auto summary = nlohmann::json::parse(file);
  const auto& ours = summary["sequences"][0]["methods"][1];
  EXPECT_EQ(ours["method"], "switches");
  EXPECT_EQ(ours["inliers"], 20);
  EXPECT_LT(ours["object_mean_m"], 1e-3);
  EXPECT_EQ(text_.find("cam_gt.txt"), std::string::npos) << text_;
}

TEST_F(ObjectsApp, TruthIsOptional) {
  write_sequence(false);
  ASSERT_EQ(run((folder / "table").string()), 0) << text_;
  EXPECT_NE(text_.find("20/30"), std::string::npos) << text_;
  EXPECT_NE(text_.find("table: no cam_gt.txt"), std::string::npos) << text_;
}

TEST_F(ObjectsApp, AsksWhetherTheRealPartIsFirst) {
  write_sequence(false);
  run((folder / "table").string());
  EXPECT_EQ(text_.find("is qw first?"), std::string::npos) << text_;
  write_sequence(false, "1 0 0 0");
  run((folder / "table").string());
  EXPECT_NE(text_.find("table/odom.txt: read as qx qy qz qw"), std::string::npos) << text_;
  EXPECT_NE(text_.find("is qw first?"), std::string::npos) << text_;
}

TEST_F(ObjectsApp, BadInputWritesNothing) {
  EXPECT_EQ(run((folder / "table").string()), 1);
  EXPECT_NE(text_.find("holds no sightings"), std::string::npos) << text_;
  write_sequence(false);
  const std::string twice = (folder / "table").string();
  EXPECT_EQ(run(twice + " " + twice), 1);
  EXPECT_NE(text_.find("same name"), std::string::npos) << text_;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

}  // namespace
}  // namespace hybrid
