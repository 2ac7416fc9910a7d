// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "tests/apps/replay_runner.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class PrintedConfig : public ReplayTest {
 protected:
  /// What the program prints of an INI, called in `where`.
  static std::string printed(const std::string& program, const std::string& ini,
                             const fs::path& where) {
    const Ran ran = run_app(
        program + (ini.empty() ? "" : " -c " + ini) + " --print-config",
        "export HYBRID_DATA_DIR=" + testing::data_path("") + "; cd " + where.string() + " && ");
    EXPECT_EQ(ran.code, 0) << program << " " << ini << ": " << ran.text;
    return ran.text;
  }
};

std::string program_of(const fs::path& ini) {
  if (ini.parent_path().filename() == "experiments") return "hybrid-experiment";
  return ini.filename().string().rfind("simulate_", 0) == 0 ? "hybrid-simulate" : "hybrid-replay";
}

TEST_F(PrintedConfig, ReadsBackFromAnyFolder) {
  int configs = 0;
  for (const auto& entry : fs::recursive_directory_iterator(HYBRID_SOURCE_DIR "/config")) {
    if (entry.path().extension() != ".ini") continue;
    const bool needs_data = entry.path().parent_path().filename() == "experiments";
    if (needs_data && !fs::exists(testing::data_path("pose_graphs"))) continue;
    ++configs;
    const std::string program = program_of(entry.path());
    const std::string first = printed(program, entry.path().filename(), entry.path().parent_path());
    fs::create_directories(folder / "elsewhere");
    const std::string copy = write("elsewhere/my.ini", first);
    EXPECT_EQ(printed(program, copy, "/"), first) << entry.path();
  }
  EXPECT_GT(configs, 25);
}

TEST_F(PrintedConfig, DefaultsReadBack) {
  for (const char* program : {"hybrid-replay", "hybrid-simulate"}) {
    const std::string first = printed(program, "", "/");
    EXPECT_EQ(printed(program, write("my.ini", first), "/"), first);
  }
}

TEST_F(PrintedConfig, ReplaysTheSame) {
  const auto expected = summary_of("-c " + config("classed_demo.ini"));
  const std::string copy =
      write("my.ini", printed("hybrid-replay", config("classed_demo.ini"), "/"));
  const auto summary = summary_of("-c " + copy);
  EXPECT_EQ(summary["objective"], expected["objective"]);
  EXPECT_EQ(summary["truth"], expected["truth"]);
}

TEST_F(PrintedConfig, SectionsOfPluginsThatAreNotUsedAreCheckedToo) {
  const std::string own = printed("hybrid-replay", config("kf_slam_demo.ini"), "/");
  expect_failure("-c " + write("my.ini", own + "[BeaconRanges]\nsigmma = 0.1\n"), "'sigma'");
  summary_of("-c " + write("my.ini", own + "[BeaconRanges]\nsigma = 0.1\n"));
}

TEST_F(PrintedConfig, TruthOfAnotherLogIsLeftOut) {
  const std::string other = HYBRID_SOURCE_DIR "/rawlogs/classed_demo.rawlog";
  const std::string arguments =
      "-c " + config("kf_slam_demo.ini") + " --no-pictures -o " + at("out");
  const Ran ran = run_replay(arguments + " --rawlog " + other);
  EXPECT_EQ(ran.code, 0) << ran.text;
  EXPECT_EQ(ran.text.find("rmse"), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find("truth_path, truth_map are left out"), std::string::npos) << ran.text;
  EXPECT_NE(run_replay(arguments + " --set log.rawlog=" + other).text.find("are left out"),
            std::string::npos);
  const auto truth =
      "--truth-path " HYBRID_SOURCE_DIR "/rawlogs/classed_demo_ground_truth_robot_path.txt";
  const auto summary =
      summary_of("-c " + config("kf_slam_demo.ini") + " --rawlog " + other + " " + truth);
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"], 0.5);
  EXPECT_FALSE(summary["truth"].contains("landmarks"));
  // The log of the INI by another name is the same log.
  const auto same = summary_of("-c " + config("kf_slam_demo.ini") +
                               " --rawlog /usr/share/mrpt/../mrpt/datasets/kf-slam_demo.rawlog");
  EXPECT_LT(same["truth"]["trajectory"]["rmse_m"], 0.01);
}

}  // namespace
}  // namespace hybrid
