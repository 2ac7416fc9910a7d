// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

using CommandLine = ScratchFolder;

/// The program refuses the arguments with its name and `part`.
void expect_refusal(const std::string& program, const std::string& arguments,
                    const std::string& part) {
  const Ran ran = run_app(program + " " + arguments);
  EXPECT_EQ(ran.code, 1) << program << " " << arguments << "\n" << ran.text;
  EXPECT_EQ(ran.text.rfind(program + ": ", 0), 0U) << ran.text;
  EXPECT_NE(ran.text.find(part), std::string::npos) << arguments << "\n" << ran.text;
}

TEST_F(CommandLine, MistypedOptionsAreCorrected) {
  expect_refusal("hybrid-replay", "--confg x", "no option --confg; did you mean --config?");
  expect_refusal("hybrid-pgo", "a.g2o --methd=gnc", "no option --methd; did you mean --method?");
  expect_refusal("hybrid-import", "csv --odometri x", "did you mean --odometry?");
  for (const char* program : {"hybrid-experiment", "hybrid-objects", "hybrid-register",
                              "hybrid-simulate", "hybrid-switching"}) {
    expect_refusal(program, "--versio", "no option --versio; did you mean --version?");
    expect_refusal(program, "--qqqqqqqq", "no option --qqqqqqqq\n");
  }
}

TEST_F(CommandLine, FormatsAreListed) {
  for (const char* arguments : {"foo", ""}) {
    expect_refusal("hybrid-import", arguments, "victoria-park mrclam kitti kitti-tracking stata");
  }
  expect_refusal("hybrid-import", "plazza a.fg", "did you mean plaza?");
}

TEST_F(CommandLine, AMissingFileIsOnePhrase) {
  const std::string none = at("none");
  const std::pair<const char*, std::string> calls[] = {
      {"hybrid-replay", none},
      {"hybrid-replay", "-c " + none},
      {"hybrid-replay", none + " -p " + none},
      {"hybrid-pgo", none},
      {"hybrid-pgo", none + " -c " + none},
      {"hybrid-experiment", "-c " + none},
      {"hybrid-simulate", "-c " + none + " -o " + at("a.rawlog")},
      {"hybrid-register", none + " " + none},
      {"hybrid-switching", none},
      {"hybrid-import", "plaza " + none + " -o " + at("a.rawlog")}};
  for (const auto& [program, arguments] : calls) {
    expect_refusal(program, arguments, none + ": no such file");
  }
  expect_refusal("hybrid-objects", none, none + ": no such folder");
}

TEST_F(CommandLine, FilesOfOtherProgramsAreNamed) {
  const std::string replay = write("replay.ini", "[log]\nrawlog = a.rawlog\n");
  const std::string simulate = write("simulate.ini", "[world]\n");
  const std::string experiment = write("experiment.ini", "[experiment]\n");
  expect_refusal("hybrid-replay", "-c " + simulate, "a section of hybrid-simulate");
  expect_refusal("hybrid-replay", "-c " + experiment, "a section of hybrid-experiment");
  expect_refusal("hybrid-simulate", "-c " + replay + " -o " + at("a.rawlog"),
                 "a section of hybrid-replay");
  expect_refusal("hybrid-experiment", "-c " + replay, "a section of hybrid-replay");
  expect_refusal("hybrid-pgo", "a.g2o -c " + replay, "a section of hybrid-replay");
  expect_refusal("hybrid-pgo", replay, "this is an INI file, not a pose graph");
  expect_refusal("hybrid-pgo", write("a.csv", "time,x\n0,1\n"), "a table, not a pose graph");
  expect_refusal("hybrid-replay", replay, "this is an INI file: give it with -c");
  const std::string log = HYBRID_SOURCE_DIR "/rawlogs/classed_demo.rawlog";
  expect_refusal("hybrid-pgo", log, "use hybrid-replay");
}

}  // namespace
}  // namespace hybrid
