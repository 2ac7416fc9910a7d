// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

namespace {

namespace fs = std::filesystem;

struct Result {
  int code = -1;
  std::string text;
};

Result run(const std::string& arguments) {
  Result result;
  FILE* pipe =
      popen((HYBRID_BINARY_DIR "/bin/hybrid-simulate " + arguments + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) result.text += buffer.data();
  result.code = WEXITSTATUS(pclose(pipe));
  return result;
}

class Simulate : public testing::Test {
 protected:
  Simulate() { fs::create_directories(folder); }
  ~Simulate() override { fs::remove_all(folder); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }
  void expect_failure(const std::string& arguments, const std::string& part) const {
    const Result result = run(arguments);
    EXPECT_NE(result.code, 0) << arguments;
    EXPECT_NE(result.text.find(part), std::string::npos) << result.text;
  }
  std::string at(const std::string& name) const { return (folder / name).string(); }

  const fs::path folder =
      fs::temp_directory_path() / ("hybrid_simulate_" + std::to_string(getpid()));
};

TEST_F(Simulate, WritesLogAndTruthAndNothingElse) {
  write("a.ini", "[world]\nlandmarks = 5\n");
  const Result result = run("-c " + at("a.ini") + " -o " + at("new/log.rawlog"));
  EXPECT_EQ(result.code, 0) << result.text;
  EXPECT_TRUE(fs::exists(at("new/log.rawlog")));
  EXPECT_TRUE(fs::exists(at("new/log_ground_truth.txt")));
  EXPECT_TRUE(fs::exists(at("new/log_ground_truth_robot_path.txt")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "new"), {}), 3);
}

TEST_F(Simulate, ExplainsItself) {
  EXPECT_EQ(run("--help").code, 0);
  const Result keys = run("--print-config");
  EXPECT_EQ(keys.code, 0);
  EXPECT_NE(keys.text.find("accuracy = 0.7"), std::string::npos);
  write("printed.ini", keys.text);
  EXPECT_EQ(run("-c " + at("printed.ini") + " -o " + at("p.rawlog")).code, 0);
}

TEST_F(Simulate, FailsClearly) {
  write("unknown.ini", "[world]\nlandmark = 5\n");
  write("type.ini", "[world]\nlandmarks = many\n");
  write("good.ini", "[world]\nlandmarks = 5\n");
  const std::string out = " -o " + at("x.rawlog");
  expect_failure("-c " + at("unknown.ini") + out, "unknown.ini:2: [world] has no key 'landmark'");
  expect_failure("-c " + at("type.ini") + out, "type.ini:2: [world] landmarks = 'many'");
  expect_failure("-c " + at("none.ini") + out, "none.ini: no such file");
  expect_failure("-c " + at("good.ini"), "-o F.rawlog");
  expect_failure("-c " + at("good.ini") + " --seed x" + out, "command line: [simulation] seed");
  expect_failure("-c " + at("good.ini") + " -o /proc/none/x.rawlog", "/proc/none");
  EXPECT_FALSE(fs::exists(at("x.rawlog")));
}

}  // namespace
