// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/math/CMatrixF.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <sys/stat.h>

#include <random>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/input/clouds.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using Form = CObservationPointCloud::ExternalStorageFormat;

constexpr const char* kAbsent =
    "cloud dropped: its file is not in the folder of images beside the log";
constexpr const char* kDamaged = "cloud dropped: its file beside the log cannot be read";

class CloudsBeside : public ScratchFolder {
 protected:
  CloudsBeside() { std::filesystem::create_directory(at("a_Images")); }

  static std::string kitti(const std::vector<float>& numbers) {
    return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(float)};
  }

  /// Clouds that name these files, each at a time of its own, in a.rawlog.
  void write_clouds(const std::vector<std::pair<std::string, Form>>& files,
                    const std::string& name = "a.rawlog") const {
    Objects all;
    for (const auto& [file, form] : files) {
      auto cloud = CObservationPointCloud::Create();
      cloud->timestamp = mrpt::Clock::fromDouble(100.0 + static_cast<double>(all.size()));
      cloud->sensorPose = mrpt::poses::CPose3D(0, 0, 1, 0, 0, 0);
      cloud->setAsExternalStorage(file, form);
      all.push_back(frame({cloud}));
    }
    write_log(at(name), all);
  }

  /// Numbers of points of the clouds of a log, -1 for one that is dropped.
  std::vector<int> points_in(const std::string& name = "a.rawlog") {
    RawlogOptions options;
    options.request.classes = {"CObservationPointCloud"};
    RawlogReader reader(at(name), options);
    std::vector<int> counts;
    while (const auto step = reader.next()) {
      for (const auto& observation : step->observations) {
        const auto cloud = cloud_in(*observation, dropped);
        counts.push_back(cloud ? static_cast<int>(cloud->points.size()) : -1);
        if (cloud) last = *cloud;
      }
    }
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    return counts;
  }

  DropReport dropped;
  PointCloud last;
};

TEST_F(CloudsBeside, OfEachForm) {
  write("a_Images/0.bin", kitti({1, 2, 3, 0.5F, -4, 5, 6, 0}));
  write("a_Images/1.txt", "1 2 3\n4 5 6\n7 8 9\n");
  write("a_Images/2.txt", "1 2 3 0.5\n");
  mrpt::maps::CSimplePointsMap map;
  for (int i = 0; i < 4; ++i) map.insertPoint(1, 2, static_cast<float>(i));
  mrpt::io::CFileGZOutputStream file(at("a_Images/3.mrpt"));
  mrpt::serialization::archiveFrom(file) << map;
  file.close();
  write_clouds({{"0.bin", Form::KittiBinFile},
                {"1.txt", Form::PlainTextFile},
                {"2.txt", Form::PlainTextFile},
                {"3.mrpt", Form::MRPT_Serialization}});
  EXPECT_EQ(points_in(), std::vector<int>({2, 3, 1, 4}));
  EXPECT_TRUE(dropped.empty());
  EXPECT_EQ(last.points[3], Eigen::Vector3f(1, 2, 4)) << "from the robot";
  std::filesystem::rename(at("a_Images"), at("Images"));
  EXPECT_EQ(points_in(), std::vector<int>({2, 3, 1, 4})) << "of MRPT's other folder";
}

TEST_F(CloudsBeside, ALogMayNameFilesOfItsFolderAlone) {
  write("outside.bin", kitti({1, 2, 3, 0}));
  write("a_Images/good.bin", kitti({1, 2, 3, 0}));
  std::filesystem::create_directory(at("a_Images/inner"));
  write("a_Images/inner/good.bin", kitti({1, 2, 3, 0}));
  std::filesystem::create_symlink(at("outside.bin"), at("a_Images/link.bin"));
  ASSERT_EQ(::mkfifo(at("a_Images/pipe.bin").c_str(), 0600), 0);
  std::vector<std::pair<std::string, Form>> files;
  for (const std::string& name :
       {std::string("../outside.bin"), at("outside.bin"), at("a_Images/good.bin"),
        std::string("inner/good.bin"), std::string("inner"), std::string("link.bin"),
        std::string("pipe.bin"), std::string("missing.bin"), std::string(".."), std::string("."),
        std::string("good.bin")}) {
    files.emplace_back(name, Form::KittiBinFile);
  }
  write_clouds(files);
  std::vector<int> expected(10, -1);
  expected.push_back(1);
  EXPECT_EQ(points_in(), expected);
  EXPECT_EQ(dropped, (DropReport{{kAbsent, 10}}));
}

TEST_F(CloudsBeside, DamagedFilesAreCounted) {
  write("a_Images/cut.bin", "1234567");
  write("a_Images/empty.bin", "");
  write("a_Images/words.txt", "one two three\n");
  write("a_Images/flat.txt", "1 2\n");
  write("a_Images/noise.mrpt", "no object of MRPT");
  write("a_Images/good.bin", kitti({1, 2, 3, 0}));
  write_clouds({{"cut.bin", Form::KittiBinFile},
                {"empty.bin", Form::KittiBinFile},
                {"words.txt", Form::PlainTextFile},
                {"flat.txt", Form::PlainTextFile},
                {"noise.mrpt", Form::MRPT_Serialization},
                {"good.bin", static_cast<Form>(77)},
                {"good.bin", Form::KittiBinFile}});
  EXPECT_EQ(points_in(), std::vector<int>({-1, -1, -1, -1, -1, -1, 1}));
  EXPECT_EQ(dropped, (DropReport{{kDamaged, 5}, {"cloud dropped: no points", 1}}));
}

/// Of a camera whose lens distorts. A wall leans, and one pixel in ten sees nothing.
CObservation3DRangeScan::Ptr depth_image(bool is_depth = true) {
  auto depth = CObservation3DRangeScan::Create();
  depth->timestamp = mrpt::Clock::fromDouble(100);
  depth->sensorPose = mrpt::poses::CPose3D(0.1, 0, 1, 0.3, 0, 0);
  depth->hasRangeImage = true;
  depth->range_is_depth = is_depth;
  depth->rangeUnits = 0.0005F;
  depth->rangeImage_setSize(24, 32);
  for (int r = 0; r < 24; ++r) {
    for (int c = 0; c < 32; ++c) {
      depth->rangeImage(r, c) =
          static_cast<std::uint16_t>((r + c) % 10 == 0 ? 0 : 3000 + 20 * c + 50 * r);
    }
  }
  depth->cameraParams.ncols = 32;
  depth->cameraParams.nrows = 24;
  depth->cameraParams.setIntrinsicParamsFromValues(30, 31, 15.5, 12);
  depth->cameraParams.distortion = mrpt::img::DistortionModel::plumb_bob;
  depth->cameraParams.dist = {-0.2, 0.05, 0.003, -0.002, 0.01, 0, 0, 0};
  return depth;
}

/// Points that the depth camera of a log sees; none where the image is dropped.
class DepthBeside : public CloudsBeside {
 protected:
  using Points = std::vector<Eigen::Vector3f>;

  Points points_of(const CObservation3DRangeScan::Ptr& depth) {
    write_log(at("a.rawlog"), {frame({depth})});
    last.points.clear();
    points_in();
    return last.points;
  }

  static void expect_near(const Points& points, const Points& expected) {
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_LT((points[i] - expected[i]).norm(), 2e-4) << i;
    }
  }
};

TEST_F(DepthBeside, RangeImagesAsIfTheyWereInTheLog) {
  for (const bool is_depth : {true, false}) {
    const Points inside = points_of(depth_image(is_depth));
    ASSERT_GT(inside.size(), 600U);
    for (const bool is_text : {false, true}) {
      const auto depth = depth_image(is_depth);
      CObservation3DRangeScan::EXTERNALS_AS_TEXT(is_text);
      depth->rangeImage_convertToExternalStorage("0.bin", at("a_Images"));
      expect_near(points_of(depth), inside);
    }
  }
  EXPECT_TRUE(dropped.empty());
}

TEST_F(DepthBeside, RangeImagesInMetresOfAFormerMrpt) {
  const auto depth = depth_image();
  const Points inside = points_of(depth_image());
  mrpt::math::CMatrixF metres(24, 32);
  for (int r = 0; r < 24; ++r) {
    for (int c = 0; c < 32; ++c) {
      metres(r, c) = static_cast<float>(depth->rangeImage(r, c)) * depth->rangeUnits;
    }
  }
  CObservation3DRangeScan::EXTERNALS_AS_TEXT(false);
  depth->rangeImage_convertToExternalStorage("0.bin", at("a_Images"));
  mrpt::io::CFileGZOutputStream file(at("a_Images/0.bin"));
  mrpt::serialization::archiveFrom(file) << metres;
  file.close();
  expect_near(points_of(depth), inside);
}

TEST_F(DepthBeside, PointsAsIfTheyWereInTheLog) {
  const auto with_points = [] {
    auto depth = depth_image();
    depth->hasRangeImage = false;
    depth->hasPoints3D = true;
    depth->resizePoints3DVectors(5);
    for (std::size_t i = 0; i < 5; ++i) {
      const auto number = static_cast<float>(i);
      depth->points3D_x[i] = 2 + number;
      depth->points3D_y[i] = 0.25F * number;
      depth->points3D_z[i] = -number;
    }
    return depth;
  };
  const Points inside = points_of(with_points());
  ASSERT_EQ(inside.size(), 5U);
  for (const bool is_text : {false, true}) {
    const auto depth = with_points();
    CObservation3DRangeScan::EXTERNALS_AS_TEXT(is_text);
    depth->points3D_convertToExternalStorage("0.bin", at("a_Images"));
    expect_near(points_of(depth), inside);
  }
  const auto both = depth_image();
  both->hasPoints3D = true;
  CObservation3DRangeScan::EXTERNALS_AS_TEXT(false);
  both->points3D_convertToExternalStorage("absent.bin", at("a_Images"));
  std::filesystem::remove(at("a_Images/absent.bin"));
  EXPECT_EQ(points_of(both), points_of(depth_image())) << "the image of the log is used";
  EXPECT_TRUE(dropped.empty());
}

TEST_F(DepthBeside, DamagedAndMissingFilesAreCounted) {
  const auto depth = depth_image();
  CObservation3DRangeScan::EXTERNALS_AS_TEXT(false);
  depth->rangeImage_convertToExternalStorage("0.bin", at("a_Images"));
  const std::string file = at("a_Images/0.bin");
  const std::string bytes = read_file(file);
  const auto number = [](std::uint32_t n) {
    return std::string(reinterpret_cast<const char*>(&n), sizeof n);
  };
  std::string garbled = bytes;
  garbled[bytes.size() / 2] = static_cast<char>(garbled[bytes.size() / 2] ^ 1);
  const std::string damaged[] = {"",
                                 "no image",
                                 bytes.substr(0, bytes.size() / 2),
                                 garbled,
                                 number(2) + number(2) + "1234567",
                                 number(2) + number(2) + "123456789",
                                 number(4'000'000'000) + number(2),
                                 number(9'000'000) + number(9'000'000) + "1234",
                                 "\x88"
                                 "CMatrixX" +
                                     number(0) + number(0),
                                 "\x80"
                                 "CMatrixX" +
                                     number(0) + number(0)};
  for (const std::string& text : damaged) {
    write("a_Images/0.bin", text);
    EXPECT_TRUE(points_of(depth).empty()) << text.size();
  }
  EXPECT_EQ(dropped, (DropReport{{kDamaged, std::size(damaged)}}));
  dropped.clear();
  write("outside.bin", bytes);
  std::filesystem::remove(file);
  EXPECT_TRUE(points_of(depth).empty());
  std::filesystem::create_symlink(at("outside.bin"), file);
  EXPECT_TRUE(points_of(depth).empty());
  EXPECT_EQ(dropped, (DropReport{{kAbsent, 2}}));
}

/// Cuts, overwritten bytes, and pieces of the file elsewhere, by a fixed seed: each is read or
/// counted.
TEST_F(DepthBeside, AnyBytesAreReadOrCounted) {
  constexpr int kCases = 60;
  std::mt19937 random(1);
  const auto below = [&](std::size_t n) { return random() % std::max<std::size_t>(n, 1); };
  for (const bool is_text : {false, true}) {
    const auto depth = depth_image();
    CObservation3DRangeScan::EXTERNALS_AS_TEXT(is_text);
    depth->rangeImage_convertToExternalStorage("0.bin", at("a_Images"));
    const std::string name = at("a_Images/" + depth->rangeImage_getExternalStorageFile(""));
    const std::string bytes = read_file(name);
    for (int i = 0; i < kCases; ++i) {
      std::string other = bytes;
      if (i % 3 == 0) other.resize(below(other.size()));
      for (std::size_t k = 0; i % 3 == 1 && k < 1 + below(8); ++k) {
        other[below(other.size())] = static_cast<char>(random());
      }
      if (i % 3 == 2) other.insert(below(other.size()), other.substr(below(other.size()), 20));
      write("a_Images/" + std::filesystem::path(name).filename().string(), other);
      dropped.clear();
      const bool is_read = !points_of(depth).empty();
      EXPECT_EQ(is_read, dropped.empty()) << "case " << i;
    }
  }
  CObservation3DRangeScan::EXTERNALS_AS_TEXT(false);
}

/// MRPT keeps a table for each pose of a camera, of 7 MB at this size.
TEST_F(DepthBeside, ACameraThatTurnsOnItsMast) {
  Objects all;
  for (int i = 0; i < 60; ++i) {
    auto depth = CObservation3DRangeScan::Create();
    depth->timestamp = mrpt::Clock::fromDouble(100.0 + i);
    depth->sensorPose.setFromValues(0, 0, 1, 0.01 * i, 0, 0);
    depth->hasRangeImage = true;
    depth->rangeImage_setSize(480, 640);
    depth->rangeImage.fill(0);
    depth->rangeImage(200, 300) = 1000;
    depth->cameraParams.ncols = 640;
    depth->cameraParams.nrows = 480;
    depth->cameraParams.setIntrinsicParamsFromValues(500, 500, 320, 240);
    all.push_back(frame({depth}));
  }
  write_log(at("a.rawlog"), all);
  EXPECT_EQ(points_in(), std::vector<int>(60, 1));
}

}  // namespace
}  // namespace hybrid
