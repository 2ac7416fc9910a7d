// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class ObjectsApp : public ::testing::Test {
 protected:
  ObjectsApp() { fs::create_directories(folder_ / "table"); }
  ~ObjectsApp() override { fs::remove_all(folder_); }

  /// A camera that moves sideways before a cup 1 m ahead; every third detection is 0.5 m too far.
  void write_sequence(bool truth) const {
    std::ofstream odometry(folder_ / "table/odom.txt"), cup(folder_ / "table/det_cup.txt");
    for (int i = 0; i < 30; ++i) {
      const double t = 0.1 * i, x = 0.01 * i, y = 0.001 * i * i;
      odometry << t << " " << x << " " << y << " 0 0 0 0 1\n";
      cup << t << " " << -x << " " << -y << (i % 3 == 2 ? " 1.5" : " 1") << " 0 0 0 1\n";
    }
    odometry.close();
    cup.close();
    if (!truth) return;
    fs::copy(folder_ / "table/odom.txt", folder_ / "table/cam_gt.txt");
    fs::copy(folder_ / "table/det_cup.txt", folder_ / "table/objgt_cup.txt");
  }
  int run(const std::string& sequences) {
    const std::string command = HYBRID_BINARY_DIR "/bin/hybrid-objects " + sequences + " -o " +
                                (folder_ / "out").string() + " 2>&1";
    FILE* pipe = popen(command.c_str(), "r");
    std::array<char, 4096> buffer{};
    text_.clear();
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text_ += buffer.data();
    return WEXITSTATUS(pclose(pipe));
  }

  fs::path folder_ = fs::temp_directory_path() / ("objects_app_" + std::to_string(::getpid()));
  std::string text_;
};

TEST_F(ObjectsApp, WritesObjectsTrajectorySummaryAndPicture) {
  write_sequence(true);
  ASSERT_EQ(run((folder_ / "table/").string()), 0) << text_;
  for (const char* name : {"objects.csv", "trajectory.tum", "objects.png"}) {
    EXPECT_GT(fs::file_size(folder_ / "out/table" / name), 0u) << name;
  }
  std::ifstream file(folder_ / "out/summary.json");
  const auto summary = nlohmann::json::parse(file);
  const auto& ours = summary["sequences"][0]["methods"][1];
  EXPECT_EQ(ours["method"], "switches");
  EXPECT_EQ(ours["inliers"], 20);
  EXPECT_LT(ours["object_mean_m"], 1e-3);
}

TEST_F(ObjectsApp, TruthIsOptional) {
  write_sequence(false);
  ASSERT_EQ(run((folder_ / "table").string()), 0) << text_;
  EXPECT_NE(text_.find("20/30"), std::string::npos) << text_;
}

TEST_F(ObjectsApp, BadInputWritesNothing) {
  EXPECT_EQ(run((folder_ / "table").string()), 1);
  EXPECT_NE(text_.find("holds no sightings"), std::string::npos) << text_;
  write_sequence(false);
  const std::string twice = (folder_ / "table").string();
  EXPECT_EQ(run(twice + " " + twice), 1);
  EXPECT_NE(text_.find("same name"), std::string::npos) << text_;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

}  // namespace
}  // namespace hybrid
