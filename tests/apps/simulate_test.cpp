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
