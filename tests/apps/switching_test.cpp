// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <utility>

#include "libhybrid/geometry/se2.h"
#include "tests/apps/run_app.h"
#include "tests/support/data_path.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;
using testing::data_path;

class SwitchingApp : public ScratchFolder {
 protected:
  int run(const std::string& arguments) {
    const Ran ran = run_app("hybrid-switching " + arguments + " -o " + at("out"));
    text = ran.text;
    return ran.code;
  }

  nlohmann::json summary() const {
    std::ifstream file(folder / "out" / "summary.json");
    return nlohmann::json::parse(file);
  }

  void expect_failure(const std::string& arguments, const std::string& part) {
    EXPECT_EQ(run(arguments), 1) << text;
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_FALSE(fs::exists(folder / "out" / "summary.json"));
  }

  std::string text;
};

/// Rows "k label x y heading" of something that turns left, right and left again. Labels count from
/// `first`.
std::string turning_table(int n, int first = 0) {
  std::mt19937 random(3);
  std::ostringstream rows;
  rows << "# k label x y heading\n";
  double heading = 0;
  for (int k = 0; k < n; ++k) {
    const int label = k / 40 % 2;
    heading += (label == 0 ? 0.2 : -0.2) + 0.05 * (random() / 4294967296.0 - 0.5);
    rows << k << ' ' << first + label << ' ' << std::cos(heading) << ' ' << std::sin(heading) << ' '
         << std::remainder(heading, 2 * M_PI) << '\n';
  }
  return rows.str();
}

/// A robot that drives in a circle between four anchors, its ranges and wheel speeds exact; or that
/// also slides to the left. All lengths are multiples of a unit, all positions are shifted.
struct CircleLog {
  double side = 0, unit = 1, shift = 0;  // m/s, lengths in one metre, m

  /// Rows of the log, and of the truth.
  std::pair<std::string, std::string> texts() const {
    constexpr double kStep = 0.25, kForward = 0.5, kTurn = 0.3, kHalfBase = 0.15;
    const double u = unit;
    const Eigen::Vector2d anchors[] = {{0, 0}, {8, 0}, {8, 6}, {0, 6}};
    std::string log, truth;
    SE2 T(2, 1, 0);
    for (int i = 0; i < 160; ++i) {
      const Eigen::Vector2d& a = anchors[i % 4];
      const double range = (T.translation() - a).norm();
      log += fmt::format("range2 {} {} {} {} {} {}\n", i * kStep, range * u, 0.0025 * u * u,
                         (a.x() + shift) * u, (a.y() + shift) * u, i % 4);
      log += fmt::format("odom2diff {} {} {} {} {} {} {} {}\n", i * kStep,
                         (kForward - kTurn * kHalfBase) * u, (kForward + kTurn * kHalfBase) * u,
                         side * u, kHalfBase * u, 1e-4 * u * u, 1e-4 * u * u, 1e-4 * u * u);
      truth +=
          fmt::format("point2 {} {} {}\n", i * kStep, (T.x() + shift) * u, (T.y() + shift) * u);
      T = T * SE2::exp({kForward * kStep, side * kStep, kTurn * kStep});
    }
    return {log, truth};
  }
};

/// Locates by a log; the mean error of the worst method, in the unit of the log.
class RangesApp : public SwitchingApp {
 protected:
  double largest_mean_error(const CircleLog& circle) {
    const auto [log, truth] = circle.texts();
    EXPECT_EQ(run(write("log.txt", log) + " --no-pictures --truth " + write("truth.txt", truth)), 0)
        << text;
    double largest = 0;
    const auto result = summary();
    for (const auto& method : result["methods"]) {
      largest = std::max(largest, method["truth"]["mean_m"].get<double>());
    }
    return largest;
  }
};

TEST_F(SwitchingApp, LabelsASeriesAndWritesEverything) {
  const std::string table = write("table.txt", turning_table(400));
  ASSERT_EQ(run("--angle-columns 5 --names left,right " + table), 0) << text;
  EXPECT_GE(summary()["accuracy"].get<double>(), 0.97);
  for (const char* name : {"labels.csv", "modes.png", "path.png"}) {
    EXPECT_GT(fs::file_size(folder / "out" / name), 1000U) << name;
  }
  ASSERT_EQ(run(table + " --without-labels --folds 4 --no-pictures"), 0) << text;
  EXPECT_GE(summary()["accuracy"].get<double>(), 0.97);
}

TEST_F(SwitchingApp, LabelsMayCountFromOne) {
  const std::string table = write("table.txt", turning_table(400, 1));
  for (const char* more : {"", " --without-labels"}) {
    ASSERT_EQ(run(table + " --no-pictures" + more), 0) << text;
    EXPECT_EQ(summary()["modes"], 2);
    EXPECT_EQ(summary()["labels"], (std::vector<int>{1, 2}));
    EXPECT_GE(summary()["accuracy"].get<double>(), 0.97) << more;
    EXPECT_EQ(read("out/labels.csv").substr(0, 31), "row,fold,label,mode,p1,p2\n0,0,1");
  }
}

TEST_F(SwitchingApp, BadInputIsNamed) {
  expect_failure("/nonexistent.txt", "/nonexistent.txt: no such file");
  expect_failure(write("empty.txt", ""), "empty.txt: holds no row");
  expect_failure(write("short.txt", "0 1 2.0\n"), "short.txt:1:8: 3 columns; expected: 5 columns");
  expect_failure(write("nan.txt", "# x\n0 1 2 3 nan\n"),
                 "nan.txt:2:9: 'nan' is not a finite number");
  expect_failure(write("label.txt", "0 1.5 2 3 4\n"), "label.txt:1:3: '1.5' is not a whole number");
  expect_failure(write("short.txt", turning_table(60)),
                 "short.txt: no instant to learn from is labelled");
  expect_failure(write("log.txt", "range2 0 -1 0.01 0 0 1\n"), "log.txt:1:10: a range must not be");
  expect_failure(write("log.txt", "range2 0 1 0.01 0 0 1\n"), "both are needed");
  expect_failure(write("log.txt", "range2 0 1 0.01 0 0 1\nwhat 1\n"), "log.txt:2:1: 'what' is");
}

TEST_F(SwitchingApp, BeeDance) {
  const std::string table = data_path("bee_dance/seqA_train0.txt");
  if (!fs::exists(table)) GTEST_SKIP() << "needs bee_dance";
  ASSERT_EQ(run(table + " --no-pictures"), 0) << text;
  EXPECT_EQ(summary()["instants"].get<int>(), 757);
  EXPECT_GE(summary()["accuracy"].get<double>(), 0.92);
  const nlohmann::json folds = summary()["fold_accuracy"];
  for (const auto& fold : folds) EXPECT_GE(fold.get<double>(), 0.9);
  ASSERT_EQ(run(table + " --no-pictures --without-labels"), 0) << text;
  EXPECT_GE(summary()["accuracy"].get<double>(), 0.9);
}

TEST_F(RangesApp, AnchorsMayHaveLargeCoordinatesAndAnyUnit) {
  CircleLog utm, millimetres;
  utm.shift = 4e5;
  millimetres.unit = 1000;
  for (const CircleLog& circle : {CircleLog(), utm, millimetres}) {
    EXPECT_LT(largest_mean_error(circle), 0.01 * circle.unit) << circle.shift;
  }
}

TEST_F(RangesApp, ARobotMaySlideSideways) {
  CircleLog sliding;
  sliding.side = 0.2;
  EXPECT_LT(largest_mean_error(sliding), 0.01);
}

TEST_F(SwitchingApp, RangesOutOfSight) {
  const std::string log = data_path("indoor_uwb_nlos/Indoor_UWB_Input.txt");
  if (!fs::exists(log)) GTEST_SKIP() << "needs indoor_uwb_nlos";
  const std::string truth = data_path("indoor_uwb_nlos/Indoor_UWB_GT.txt");
  ASSERT_EQ(run(log + " --truth " + truth), 0) << text;
  const auto error = [&](const char* method) {
    return summary()["methods"][method]["truth"]["mean_m"].get<double>();
  };
  EXPECT_LT(error("modes"), 0.045);
  EXPECT_LT(error("modes"), 0.7 * error("cauchy"));
  EXPECT_LT(error("modes"), 0.7 * error("narrow cauchy"));
  for (const char* name : {"trajectory.csv", "ranges.csv", "modes.png", "path.png"}) {
    EXPECT_GT(fs::file_size(folder / "out" / name), 1000U) << name;
  }
}

}  // namespace
}  // namespace hybrid
