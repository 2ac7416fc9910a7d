// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

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

TEST_F(CommandLine, AWordTooManyIsNamed) {
  expect_refusal("hybrid-map", "export a.hmap --mcap b.mcap", "'b.mcap' is one argument too many");
}

TEST_F(CommandLine, AVideoIsToldHowToBeMadeOfFrames) {
  expect_refusal("hybrid-replay", "--video a.mp4", "ffmpeg -framerate 10 -i OUT/frames/frame_%04d");
}

TEST_F(CommandLine, FormatsAreListed) {
  for (const char* arguments : {"foo", ""}) {
    expect_refusal("hybrid-import", arguments, "victoria-park mrclam kitti kitti-tracking stata");
  }
  expect_refusal("hybrid-import", "plazza a.fg", "did you mean plaza?");
  expect_refusal("hybrid-import", "yolo labels", "'yolo' is a form of csv: hybrid-import csv");
  expect_refusal("hybrid-import", "g2o a.g2o", "hybrid-pgo F.g2o");
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

/// All texts of --help, those of commands too.
const std::vector<std::string>& help_texts() {
  static std::vector<std::string> texts;
  if (!texts.empty()) return texts;
  for (const char* command :
       {"hybrid-experiment", "hybrid-import", "hybrid-import csv", "hybrid-import kitti",
        "hybrid-map", "hybrid-map export", "hybrid-map join", "hybrid-objects", "hybrid-pgo",
        "hybrid-register", "hybrid-replay", "hybrid-simulate", "hybrid-switching"}) {
    texts.push_back(run_app(std::string(command) + " --help").text);
  }
  return texts;
}

/// The column where what is said of an option begins in a line of --help.
std::size_t column_of_meaning(const std::string& line) {
  const bool is_name = line.rfind("  -", 0) == 0;
  const std::size_t gap = is_name ? line.find("  ", 2) : 0;
  return line.find_first_not_of(' ', gap);
}

TEST_F(CommandLine, HelpKeepsItsColumns) {
  for (const std::string& text : help_texts()) {
    EXPECT_EQ(text.find("\n\n\n"), std::string::npos) << text;
    std::istringstream lines(text);
    bool in_options = false;
    std::size_t meanings = 0;
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 100U) << line;
      if (line.empty() || line[0] != ' ') in_options = line == "Options:";
      if (!in_options || line[0] != ' ') continue;
      const std::size_t column = column_of_meaning(line);
      if (column == std::string::npos) continue;  // a long name, whose meaning is below
      EXPECT_EQ(column, 30U) << line;
      ++meanings;
    }
    EXPECT_GT(meanings, 1U) << text;
  }
}

TEST_F(CommandLine, HelpTellsValuesInWords) {
  for (const std::string& text : help_texts()) {
    for (const char* mark :
         {"{", "Excludes", "REQUIRED", "INT in", "FLOAT", " x 2", "(2x)", "=["}) {
      EXPECT_EQ(text.find(mark), std::string::npos) << mark << "\n" << text;
    }
  }
  const std::string help = run_app("hybrid-replay --help").text;
  EXPECT_NE(help.find("(one of: auto build"), std::string::npos) << help;
  EXPECT_NE(help.find("(default hybrid-replay-out)"), std::string::npos) << help;
  EXPECT_NE(run_app("hybrid-pgo --help").text.find("not with --method"), std::string::npos);
}

TEST_F(CommandLine, HelpFitsTheTerminal) {
  for (const auto& [columns, widest] :
       {std::pair(70, 70U), std::pair(40, 60U), std::pair(300, 100U)}) {
    const std::string command = "script -qec 'stty cols " + std::to_string(columns) + "; " +
                                HYBRID_BINARY_DIR "/bin/hybrid-import csv --help' /dev/null";
    std::istringstream lines(run_shell(command).text);
    std::size_t longest = 0;
    for (std::string line; std::getline(lines, line);) {
      longest = std::max(longest, line.size() - (!line.empty() && line.back() == '\r' ? 1 : 0));
    }
    EXPECT_LE(longest, widest);
    EXPECT_GT(longest, widest - 8);
  }
}

}  // namespace
}  // namespace hybrid
