// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/video.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <exception>
#include <filesystem>
#include <iterator>
#include <string>

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class Video : public testing::Test {
 protected:
  Video() { fs::create_directories(folder_); }
  ~Video() override { fs::remove_all(folder_); }

  static Image picture(int i, int width = 64) {
    return {width, 48, std::vector<std::uint8_t>(width * 48 * 3, static_cast<std::uint8_t>(i))};
  }
  auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }
  /// Expects an error that holds `part`, and no file.
  template <class Write>
  void expect_error(Write write, const std::string& part) const {
    try {
      write();
      FAIL() << "no error";
    } catch (const std::exception& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
    EXPECT_EQ(files(), 0);
  }

  const fs::path folder_ = fs::temp_directory_path() / ("hybrid_video_" + std::to_string(getpid()));
};

TEST_F(Video, TakesEveryPictureOnceInOrder) {
  int next = 0;
  save_video(folder_ / "a.mp4", 12, [&](int i) {
    EXPECT_EQ(i, next++);
    return picture(20 * i);
  });
  EXPECT_EQ(next, 12);
  EXPECT_GT(fs::file_size(folder_ / "a.mp4"), 500U);
  EXPECT_EQ(files(), 1);
}

TEST_F(Video, ErrorsNameTheFileAndLeaveNothing) {
  const auto still = [](int i) { return picture(i); };
  expect_error([&] { save_video(folder_ / "a.gif", 3, still); }, "a.gif");
  expect_error([&] { save_video(folder_ / "no" / "a.mp4", 3, still); }, "there is no folder");
  expect_error(
      [&] { save_video(folder_ / "a.mp4", 3, [](int i) { return picture(i, 64 + 2 * i); }); },
      "picture 1 is 66 x 48");
}

TEST_F(Video, CheckLeavesNoFile) {
  check_video(folder_ / "a.mp4");
  EXPECT_EQ(files(), 0);
  expect_error([&] { check_video(folder_ / "a.gif"); }, "ends in .mp4");
}

}  // namespace
}  // namespace hybrid
