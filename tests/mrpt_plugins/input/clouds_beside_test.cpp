// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <sys/stat.h>

#include "mrpt_plugins/input/clouds.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

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

TEST_F(CloudsBeside, DepthImagesBesideStayDropped) {
  auto depth = mrpt::obs::CObservation3DRangeScan::Create();
  depth->timestamp = mrpt::Clock::fromDouble(100);
  depth->hasPoints3D = true;
  depth->points3D_convertToExternalStorage("depth.bin", at("a_Images"));
  write_log(at("a.rawlog"), {frame({depth})});
  EXPECT_EQ(points_in(), std::vector<int>({-1}));
  EXPECT_EQ(dropped, (DropReport{{"cloud dropped: its points are in a file beside the log", 1}}));
}

}  // namespace
}  // namespace hybrid
