// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

Ran simulate(const std::string& arguments) {
  return run_app("hybrid-simulate " + arguments);
}

class Simulate : public ScratchFolder {
 protected:
  void expect_failure(const std::string& arguments, const std::string& part) const {
    const Ran result = simulate(arguments);
    EXPECT_NE(result.code, 0) << arguments;
    EXPECT_NE(result.text.find(part), std::string::npos) << result.text;
  }
};

TEST_F(Simulate, WritesLogAndTruthAndNothingElse) {
  write("a.ini", "[world]\nlandmarks = 5\n");
  const Ran result = simulate("-c " + at("a.ini") + " -o " + at("new/log.rawlog"));
  EXPECT_EQ(result.code, 0) << result.text;
  EXPECT_TRUE(fs::exists(at("new/log.rawlog")));
  EXPECT_TRUE(fs::exists(at("new/log_ground_truth.txt")));
  EXPECT_TRUE(fs::exists(at("new/log_ground_truth_robot_path.txt")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "new"), {}), 3);
}

TEST_F(Simulate, FixesAreTruthThatReplayScores) {
  write(
      "a.ini",
      "[path]\nradius = 40\nstep = 2\n[world]\nlandmarks = 20\nmin_corner = -45 -5 0\n"
      "max_corner = 45 85 0\n[sensor]\nmax_range = 30\n[fixes]\nperiod = 1\nfalse_share = 0.05\n");
  const Ran made = simulate("-c " + at("a.ini") + " -o " + at("log.rawlog"));
  EXPECT_EQ(made.code, 0) << made.text;
  EXPECT_NE(made.text.find(" fixes\n"), std::string::npos) << made.text;
  const std::string truth = at("log_ground_truth_fixes.csv");
  EXPECT_TRUE(fs::exists(truth));
  const std::string replay = "hybrid-replay " + at("log.rawlog") + " --no-pictures -o " + at("out");
  const Ran scored = run_app(replay + " --set log.truth_fixes=" + truth);
  EXPECT_EQ(scored.code, 0) << scored.text;
  EXPECT_NE(scored.text.find(", false fixes precision "), std::string::npos) << scored.text;
  const Ran late =
      run_app(replay + " --set reader.clock_offset=1e5 --set log.truth_fixes=" + truth);
  EXPECT_EQ(late.code, 0) << late.text;
  write("other.csv", "time,mode,error_east,error_north,error_up\n1,good,0,0,0\n");
  const Ran other = run_app(replay + " --set log.truth_fixes=" + at("other.csv"));
  EXPECT_NE(other.text.find("other.csv: its rows are of 1.000 to 1.000 s"), std::string::npos)
      << other.text;
}

TEST_F(Simulate, ExplainsItself) {
  EXPECT_EQ(simulate("--help").code, 0);
  const Ran keys = simulate("--print-config");
  EXPECT_EQ(keys.code, 0);
  EXPECT_NE(keys.text.find("accuracy = 0.7"), std::string::npos);
  write("printed.ini", keys.text);
  EXPECT_EQ(simulate("-c " + at("printed.ini") + " -o " + at("p.rawlog")).code, 0);
}

TEST_F(Simulate, FailsClearly) {
  write("unknown.ini", "[world]\nlandmark = 5\n");
  write("type.ini", "[world]\nlandmarks = many\n");
  write("good.ini", "[world]\nlandmarks = 5\n");
  const std::string out = " -o " + at("x.rawlog");
  expect_failure("-c " + at("unknown.ini") + out, "unknown.ini:2:1: [world] has no key 'landmark'");
  expect_failure("-c " + at("type.ini") + out, "type.ini:2:1: [world] landmarks = 'many'");
  expect_failure("-c " + at("none.ini") + out, "none.ini: no such file");
  expect_failure("-c " + at("good.ini"), "-o F.rawlog");
  expect_failure("-c " + at("good.ini") + " --seed x" + out, "command line: [simulation] seed");
  expect_failure("-c " + at("good.ini") + " -o /proc/none/x.rawlog", "/proc/none");
  EXPECT_FALSE(fs::exists(at("x.rawlog")));
}

}  // namespace
}  // namespace hybrid
