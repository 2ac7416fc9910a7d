// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/video.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <filesystem>
#include <iterator>
#include <string>

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class Video : public ::testing::Test {
 protected:
  Video() { fs::create_directories(folder_); }
  ~Video() override { fs::remove_all(folder_); }

  static Image picture(int i, int width = 64) {
    return {width, 48, std::vector<std::uint8_t>(width * 48 * 3, static_cast<std::uint8_t>(i))};
  }
  auto files() const { return std::distance(fs::directory_iterator(folder_), {}); }
  /// Expects an error that holds `part`.
  void expect_error(const std::string& part, const std::function<Image(int)>& pictures) const {
    try {
      encode_video(folder_ / "a.mp4", 30, pictures);
      FAIL() << "no error";
    } catch (const std::exception& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }

  const fs::path folder_ = fs::temp_directory_path() / ("hybrid_video_" + std::to_string(getpid()));
};

TEST_F(Video, TakesEveryPictureOnceInOrder) {
  int next = 0;
  encode_video(folder_ / "a.mp4", 12, [&](int i) {
    EXPECT_EQ(i, next++);
    return picture(20 * i);
  });
  EXPECT_EQ(next, 12);
  EXPECT_GT(fs::file_size(folder_ / "a.mp4"), 500U);
  EXPECT_EQ(files(), 1);
}

TEST_F(Video, PicturesOfTwoSizesAreAnError) {
  expect_error("picture 1 is 66 x 48", [](int i) { return picture(i, 64 + 2 * i); });
}

TEST_F(Video, AFileThatCannotHoldItIsAnError) {
  const auto noise = [](int i) {
    Image image = picture(0, 640);
    unsigned state = static_cast<unsigned>(i) + 1;
    for (auto& byte : image.rgb)
      byte = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
    return image;
  };
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 20000;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  expect_error("the film is not complete", noise);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
}

}  // namespace
}  // namespace hybrid
