// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/apps/run_app.h"
#include "tests/libhybrid/registration/clouds.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;
using testing::Random;

Ran run_register(const std::string& arguments) {
  return run_app("hybrid-register " + arguments);
}

class RegisterApp : public ScratchFolder {
 protected:
  using ScratchFolder::write;
  std::string write(const std::string& name, const Points& points) const {
    std::ofstream out(at(name));
    out.precision(12);
    for (const Eigen::Vector3d& p : points) out << p.transpose() << '\n';
    return at(name);
  }
  Eigen::Matrix4d transform() const {
    std::ifstream in(at("out/transform.txt"));
    Eigen::Matrix4d M;
    for (int i = 0; i < 16; ++i) in >> M(i / 4, i % 4);
    return M;
  }
  nlohmann::json summary() const {
    return nlohmann::json::parse(std::ifstream(at("out/summary.json")));
  }
  Ran run_on(const std::string& source, const std::string& target,
             const std::string& more = "") const {
    return run_register("'" + source + "' '" + target + "' " + more + " -o " + at("out"));
  }
};

TEST_F(RegisterApp, WritesTransformSummaryAndPicture) {
  Random random(1);
  const Points target = testing::bumpy_surface(1500, 0.001, random);
  const SE3 truth(Eigen::Vector3d(0.1, 0.2, -0.1), SO3::exp(Eigen::Vector3d(0.2, 0.1, -0.3)));
  const Ran result =
      run_on(write("s.xyz", testing::moved(truth.inverse(), target)), write("t.xyz", target));
  ASSERT_EQ(result.code, 0) << result.text;
  EXPECT_LT((transform() - truth.matrix()).norm(), 1e-5);
  EXPECT_EQ(transform().row(3), Eigen::RowVector4d(0, 0, 0, 1));
  const auto json = summary();
  EXPECT_EQ(json["status"], "ok");
  EXPECT_EQ(json["inlier_fraction"], 1.0);
  EXPECT_LT(json["rms"].get<double>(), 1e-5);
  EXPECT_GT(json["iterations"].get<int>(), 0);
  EXPECT_GT(json["solver_s"].get<double>(), 0.0);
  EXPECT_EQ(json["covariance"].size(), 6u);
  EXPECT_GT(fs::file_size(at("out/overlay.png")), 10000u);
}

TEST_F(RegisterApp, StartsFromAMatrix) {
  Random random(2);
  const Points target = testing::bumpy_surface(800, 0.001, random);
  const SE3 truth(Eigen::Vector3d(5, 0, 0), SO3::exp(Eigen::Vector3d(0, 0, 2.5)));
  const std::string source = write("s.xyz", testing::moved(truth.inverse(), target));
  const std::string other = write("t.xyz", target);
  const std::string start = write("start.txt", "-0.8 -0.6 0 5\n0.6 -0.8 0 0\n0 0 1 0\n0 0 0 1\n");
  const Ran result = run_on(source, other, "--no-search --start " + start);
  ASSERT_EQ(result.code, 0) << result.text;
  EXPECT_LT((transform() - truth.matrix()).norm(), 1e-4);
  for (const char* bad : {"1 0 0 0\n", "2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "a", ""}) {
    EXPECT_EQ(run_on(source, other, "--start " + write("bad.txt", bad)).code, 1);
  }
}

TEST_F(RegisterApp, SaysWhichMotionIsFree) {
  Points line;
  for (int i = 0; i < 50; ++i) line.emplace_back(0.1 * i, 0, 0);
  const Ran result = run_on(write("s.xyz", line), write("t.xyz", line));
  EXPECT_EQ(result.code, 2);
  EXPECT_NE(result.text.find("rotation about the axis (1, 0, 0)"), std::string::npos)
      << result.text;
  EXPECT_EQ(summary()["status"], "unobservable");
  EXPECT_TRUE(summary()["covariance"].is_null());
}

TEST_F(RegisterApp, FewMatchesAreAPartialResult) {
  Random random(4);
  const Points target = testing::bumpy_surface(1500, 0.001, random);
  Points millimetres = target;
  for (Eigen::Vector3d& p : millimetres) p *= 1000;
  const Ran result = run_on(write("s.xyz", millimetres), write("t.xyz", target));
  EXPECT_EQ(result.code, 2) << result.text;
  EXPECT_NE(result.text.find("in the same unit"), std::string::npos) << result.text;
  EXPECT_EQ(summary()["status"], "partial");
  EXPECT_NE(summary()["message"].get<std::string>().find("in the same unit"), std::string::npos);
}

TEST_F(RegisterApp, BadInputIsToldAndNothingWritten) {
  const std::string good = write("t.xyz", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n");
  const std::pair<std::string, std::string> cases[] = {
      {write("empty.xyz", ""), "holds no point"},
      {write("tiny.xyz", "0 0 0\n1 1 1\n"), "at least 3"},
      {write("same.xyz", "1 1 1\n1 1 1\n1 1 1\n"), "all its points coincide"},
      {write("nan.xyz", "nan 0 0\nnan 1 1\n"), "none of its points is finite"},
      {write("short.pcd", "FIELDS x y z\nPOINTS 9\nDATA ascii\n1 2 3\n"), "ends after 1"},
      {write("noise.bin", "no map at all, of no kind"), "noise.bin"},
      {at("absent.ply"), "absent.ply: no such file"},
      {at("absent.map"), "absent.map"},
      {write("far.xyz", "900 0 0\n901 0 0\n900 1 0\n900 0 1\n"), "no counterparts found"}};
  for (const auto& [source, message] : cases) {
    const Ran result = run_on(source, good, "--no-search");
    EXPECT_EQ(result.code, 1) << source;
    EXPECT_NE(result.text.find(message), std::string::npos) << result.text;
    EXPECT_FALSE(fs::exists(at("out")));
  }
  EXPECT_EQ(run_register("").code, 1);
  EXPECT_EQ(run_register("--help").code, 0);
}

TEST_F(RegisterApp, ReadsPointsMapsAndScansOfRawlogs) {
  Random random(3);
  Points room;  // as seen by a scanner in an irregular room
  const auto range = [](double angle) {
    return 3.0 + std::sin(angle) + 0.8 * std::sin(2.3 * angle);
  };
  const auto map = mrpt::maps::CSimplePointsMap::Create();
  mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(M_PI);
  scan.resizeScan(361);
  for (int i = 0; i < 361; ++i) {
    const double angle = (i - 180) * 0.5 * M_PI / 180.0;
    const auto r = static_cast<float>(range(angle));
    scan.setScanRange(i, r);
    scan.setScanRangeValidity(i, true);
    map->insertPoint(static_cast<float>(r * std::cos(angle)),
                     static_cast<float>(r * std::sin(angle)), 0);
  }
  write_log(at("map.gz"), {map});
  const auto frame = mrpt::obs::CSensoryFrame::Create();
  frame->insert(mrpt::obs::CObservation2DRangeScan::Create(scan));
  const auto empty = mrpt::obs::CSensoryFrame::Create();
  const auto actions = mrpt::obs::CActionCollection::Create();
  write_log(at("log.rawlog"), {actions, empty, actions, frame});
  const Ran result = run_on(at("log.rawlog#1"), at("map.gz"), "--unit m");
  ASSERT_EQ(result.code, 0) << result.text;
  EXPECT_LT((transform() - Eigen::Matrix4d::Identity()).norm(), 1e-3);
  EXPECT_EQ(summary()["metric"], "curve");
  EXPECT_EQ(summary()["source_points"], 361);
  EXPECT_NE(run_on(at("log.rawlog#0"), at("map.gz")).text.find("no observation with points"),
            std::string::npos);
  EXPECT_NE(run_on(at("log.rawlog#9"), at("map.gz")).text.find("has 2 steps"), std::string::npos);
  EXPECT_NE(run_on(at("log.rawlog#x"), at("map.gz")).text.find("number of a step"),
            std::string::npos);
}

}  // namespace
}  // namespace hybrid
