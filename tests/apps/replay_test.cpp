// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <set>
#include <sstream>

#include "libhybrid/io/read_graph.h"
#include "tests/apps/replay_runner.h"
#include "tests/support/run_shell.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class Modes : public ReplayTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Modes, KfSlamDemoReachesTheBatchOptimum) {
  const std::string ini =
      write("a.ini", read_file(config("kf_slam_demo.ini")) + "\n[solver]\nmode = " + GetParam() +
                         "\n[BearingRangeKnownIds]\nhuber_width = 0\n");
  const auto summary = summary_of("-c " + ini);
  EXPECT_EQ(summary["mode"], GetParam());
  EXPECT_EQ(summary["status"], "ok");
  EXPECT_EQ(summary["keyframes"], 250);
  EXPECT_EQ(summary["landmarks"], 70);
  const auto& truth = summary["truth"];
  EXPECT_NEAR(truth["landmarks"]["mean_m"], 0.00257, 1e-5);
  EXPECT_NEAR(truth["landmarks"]["max_m"], 0.00575, 1e-5);
  EXPECT_NEAR(truth["trajectory"]["rmse_m"], 0.00395, 1e-5);
  EXPECT_NEAR(truth["dead_reckoning"]["rmse_m"], 0.681, 1e-3);
  EXPECT_NEAR(truth["nees_pose"], 1.0, 0.2);
  // Half the sum of squares of N - n unit normals, within 4 standard deviations.
  const double redundancy = 3607 * 2 + 249 * 3 + 3 - 250 * 3 - 70 * 2;
  EXPECT_NEAR(summary["cost"], redundancy / 2, 4 * std::sqrt(redundancy / 2));
}

INSTANTIATE_TEST_SUITE_P(Solver, Modes, ::testing::Values("batch", "incremental", "bounded"));

class Windows : public ReplayTest, public ::testing::WithParamInterface<const char*> {
 protected:
  nlohmann::json truth_of(const std::string& name) const {
    const std::string ini =
        write("a.ini", read_file(config(name)) + "\n[solver]\nlag = 20\nmode = " + GetParam());
    const std::string log = HYBRID_SOURCE_DIR "/rawlogs/classed_demo";
    const bool classed = name == "classed_demo.ini";
    const auto summary = summary_of("-c " + ini +
                                    (classed ? " --rawlog " + log + ".rawlog --truth-path " + log +
                                                   "_ground_truth_robot_path.txt --truth-map " +
                                                   log + "_ground_truth.txt"
                                             : ""));
    EXPECT_EQ(summary["mode"], GetParam());
    EXPECT_EQ(summary["status"], "ok");
    return summary["truth"];
  }
};

TEST_P(Windows, KfSlamDemoStaysNearTheBatchOptimum) {
  const auto truth = truth_of("kf_slam_demo.ini");
  EXPECT_EQ(truth["landmarks"]["matched"], 70);
  EXPECT_LT(truth["landmarks"]["mean_m"], 0.005);
  EXPECT_LT(truth["landmarks"]["max_m"], 0.02);
  EXPECT_LT(truth["trajectory"]["rmse_m"], 0.006);
}

TEST_P(Windows, ClassesAndLandmarksOutsideTheWindowRemain) {
  const auto truth = truth_of("classed_demo.ini");
  EXPECT_EQ(truth["landmarks"]["matched"], 20);
  EXPECT_LT(truth["landmarks"]["mean_m"], 0.5);
  EXPECT_LT(truth["trajectory"]["rmse_m"], 0.25);
  EXPECT_EQ(truth["class_accuracy"], 1.0);
  const auto map = nlohmann::json::parse(read_file(folder / "out" / "landmarks.json"));
  for (const auto& landmark : map["landmarks"]) {
    double sum = 0.0;
    for (const double p : landmark["class_probabilities"]) sum += p;
    EXPECT_NEAR(sum, 1.0, 1e-6) << landmark;
  }
}

INSTANTIATE_TEST_SUITE_P(Solver, Windows, ::testing::Values("fixed_lag", "filter"));

TEST_F(ReplayTest, LogInSpaceIsBetterThanFiltered) {
  const auto summary = summary_of("-c " + config("kf_slam_6d_demo.ini"));
  EXPECT_GT(summary["plugins"]["mean_ms"], 0);
  EXPECT_GE(summary["plugins"]["p95_ms"], summary["plugins"]["p50_ms"]);
  EXPECT_GE(summary["plugins"]["updates"], summary["keyframes"]);
  EXPECT_EQ(summary["plugins"]["updates_by_local_search"], 0);
  const auto truth = summary["truth"];
  EXPECT_EQ(truth["landmarks"]["matched"], 48);
  EXPECT_LT(truth["landmarks"]["mean_m"], 0.005);
  EXPECT_LT(truth["landmarks"]["max_m"], 0.0212);
  EXPECT_LT(truth["trajectory"]["rmse_m"], 0.011);
}

TEST_F(ReplayTest, SensorOffTheCentreIsHonoured) {
  const auto truth = summary_of("-c " + config("kf_slam_6d_demo_noncentered.ini"))["truth"];
  EXPECT_EQ(truth["landmarks"]["matched"], 44);
  EXPECT_LT(truth["landmarks"]["mean_m"], 0.006);
  EXPECT_LT(truth["trajectory"]["rmse_m"], 0.0097);
}

class Classed : public ReplayTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Classed, EveryClassIsRightWhereSeenFiveTimes) {
  const std::string name = GetParam();
  const auto summary = summary_of("-c " + config(name + ".ini"));
  EXPECT_LT(summary["truth"]["landmarks"]["mean_m"], 0.2);
  std::map<std::string, std::string> true_class;
  std::istringstream truth(read_file(HYBRID_SOURCE_DIR "/rawlogs/" + name + "_ground_truth.txt"));
  const std::vector<std::string> names{"tree", "car", "pole", "bench"};
  for (std::string line; std::getline(truth, line);) {
    if (line.empty() || line[0] == '%') continue;
    std::istringstream words(line);
    std::vector<std::string> row{std::istream_iterator<std::string>(words), {}};
    true_class[row.at(6)] = names.at(std::stoul(row.at(7)));
  }
  const auto map = nlohmann::json::parse(read_file(folder / "out" / "landmarks.json"));
  int checked = 0;
  for (const auto& landmark : map["landmarks"]) {
    if (landmark["sightings"] < 5) continue;
    EXPECT_EQ(landmark["class"], true_class.at(landmark["id"].dump())) << landmark;
    ++checked;
  }
  EXPECT_GE(checked, 18);
}

INSTANTIATE_TEST_SUITE_P(Logs, Classed, ::testing::Values("classed_demo", "classed_demo_3d"));

TEST_F(ReplayTest, WritesEverythingAndNothingElse) {
  const Ran ran = run_replay("-c " + config("classed_demo.ini") + " -o " + at("a/b"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  EXPECT_EQ(ran.text.find('\r'), std::string::npos);  // no progress line in a pipe
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder / "a/b")) {
    EXPECT_GT(entry.file_size(), 100U) << entry.path();
    files.insert(entry.path().filename());
  }
  const std::set<std::string> expected{"trajectory.tum",      "trajectory_dead_reckoning.tum",
                                       "landmarks.csv",       "landmarks.json",
                                       "graph.g2o",           "steps.csv",
                                       "summary.json",        "map.png",
                                       "steps.png",           "error.png",
                                       "trajectory_truth.tum"};
  EXPECT_EQ(files, expected);
}

/// The first word of every row but the heading.
std::vector<std::string> stamps_of(const std::string& tum) {
  std::vector<std::string> stamps;
  std::istringstream rows(read_file(tum));
  for (std::string row; std::getline(rows, row);) {
    if (row[0] != '#') stamps.push_back(row.substr(0, row.find(' ')));
  }
  return stamps;
}

TEST_F(ReplayTest, TheTruthHasTheStampsOfTheTrajectory) {
  summary_of("-c " + config("kf_slam_demo.ini"));
  const auto stamps = stamps_of(at("out/trajectory.tum"));
  EXPECT_EQ(stamps.size(), 250U);
  EXPECT_EQ(stamps_of(at("out/trajectory_truth.tum")), stamps);
  summary_of("--rawlog /usr/share/mrpt/datasets/kf-slam_demo.rawlog");
  EXPECT_FALSE(fs::exists(at("out/trajectory_truth.tum")));
}

TEST_F(ReplayTest, GrowingMapWhereAsked) {
  const std::string arguments = "-c " + config("classed_demo.ini") +
                                " --no-pictures --sparsity -o " + at("out") + " --frames ";
  for (const int frames : {6, 4}) {  // no frame is left of the first run
    const Ran ran = run_replay(arguments + std::to_string(frames));
    ASSERT_EQ(ran.code, 0) << ran.text;
    EXPECT_NE(ran.text.find("--sparsity is retired"), std::string::npos) << ran.text;
    EXPECT_EQ(std::distance(fs::directory_iterator(at("out/frames")), {}), frames);
  }
  std::set<std::string> pictures;
  for (int i = 1; i <= 4; ++i) {
    pictures.insert(read_file(folder / "out/frames" / ("frame_000" + std::to_string(i) + ".png")));
  }
  EXPECT_EQ(pictures.size(), 4U);  // all different: it grows
}

TEST_F(ReplayTest, PicturesInThePlaneAreLinesWhereAsked) {
  const std::string replay = "-c " + config("classed_demo.ini") + " -o " + at("out");
  ASSERT_EQ(run_replay(replay).code, 0);
  for (const std::string format : {"svg", "pdf"}) {
    const Ran ran = run_replay(replay + " --picture-format " + format);
    ASSERT_EQ(ran.code, 0) << ran.text;
    for (const char* name : {"map", "steps", "error"}) {
      const std::string start = read_file(folder / "out" / (std::string(name) + "." + format));
      EXPECT_EQ(start.substr(0, 5), format == "svg" ? "<?xml" : "%PDF-") << name;
      EXPECT_FALSE(fs::exists(folder / "out" / (std::string(name) + ".png"))) << name;
    }
  }
}

TEST_F(ReplayTest, SameInputGivesTheSameBytes) {
  summary_of("-c " + config("classed_demo.ini"));
  fs::rename(at("out"), at("first"));
  summary_of("-c " + config("classed_demo.ini"));
  for (const char* name : {"trajectory.tum", "landmarks.csv", "graph.g2o"}) {
    EXPECT_EQ(read_file(folder / "first" / name), read_file(folder / "out" / name)) << name;
  }
}

TEST_F(ReplayTest, CommandLineOverridesTheIni) {
  const std::string data = "/usr/share/mrpt/datasets/kf-slam_demo";
  const std::string ini = write("a.ini", "[log]\nrawlog = missing.rawlog\n");
  const auto summary =
      summary_of("-c " + ini + " --rawlog " + data + ".rawlog --truth-path " + data +
                 "_ground_truth_robot_path.txt --truth-map " + data + "_ground_truth.txt");
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"], 0.0049);
}

TEST_F(ReplayTest, PluginLibraryIsLoadedAndUsed) {
  const std::string ini =
      write("a.ini",
            "[log]\nrawlog = /usr/share/mrpt/datasets/kf-slam_demo.rawlog\n"
            "truth_map = /usr/share/mrpt/datasets/kf-slam_demo_ground_truth.txt\n"
            "[plugins]\nclasses = RobustBearingRange\n[RobustBearingRange]\nhuber_width = 4\n");
  const auto summary = summary_of("-c " + ini + " -p " HYBRID_EXAMPLE_PLUGIN);
  EXPECT_EQ(summary["truth"]["landmarks"]["matched"], 70);
  EXPECT_LT(summary["truth"]["landmarks"]["mean_m"], 0.004);
  fs::remove_all(at("out"));
  expect_failure("-c " + ini,
                 "'RobustBearingRange', which is not a registered mapping plugin; "
                 "registered are: BeaconRanges, BearingOnlyKnownIds, ");
  expect_failure("-c " + ini + " -p " + at("no.so"), "no such file");
  expect_failure("-c " + ini + " -p " + ini, "invalid ELF header");
}

TEST_F(ReplayTest, PluginLibrariesThatDoNotFitAreRefused) {
  const auto expect_refused = [&](const std::string& path, const std::string& part) {
    expect_failure("--print-config -p " + path, "hybrid-replay: " + path + ": " + part);
  };
  const std::string bad = HYBRID_BAD_PLUGINS "/hybrid_bad_";
  expect_refused(bad + "other_version.so",
                 "was built for hybrid 99.2.1 (MRPT 3.1.2, Eigen 3.4.0 aligned to 32 bytes); this "
                 "is hybrid ");
  expect_refused(bad + "missing_symbol.so", bad + "missing_symbol.so: undefined symbol: ");
  expect_refused(bad + "throws.so", "throws while it is loaded: no licence");
  expect_refused(bad + "exits.so", "ends the process while it is loaded");
  expect_refused(bad + "without_tag.so", "does not say what it was built for");
  expect_refused(bad + "registers_nothing.so", "registers no plugin");
  expect_refused("libm.so.6", "no such file");
  for (const char* folder : {"/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/lib64"}) {
    const std::string path = std::string(folder) + "/libm.so.6";
    if (fs::exists(path)) expect_refused(path, "registers no plugin");
  }
  EXPECT_EQ(
      run_replay("--print-config -p " HYBRID_EXAMPLE_PLUGIN " -p " HYBRID_EXAMPLE_PLUGIN).code, 0);
}

TEST_F(ReplayTest, APluginGetsTheClassesOfObservationsThatItAsksFor) {
  const auto rays = [&](const char* asks) {
    const std::string ini =
        write("a.ini", std::string("[log]\nrawlog = /usr/share/mrpt/datasets/localization_demo"
                                   ".rawlog\n[plugins]\nclasses = ScanCounter\n[ScanCounter]\n"
                                   "asks = ") +
                           asks);
    const int empty = 2;  // the plugin makes no map
    const auto summary = summary_of("-c " + ini + " -p " HYBRID_EXAMPLE_PLUGIN, empty);
    return summary["plugins"]["rays"].get<int>();
  };
  EXPECT_EQ(rays("yes"), 37 * 361);
  EXPECT_EQ(rays("no"), 37 * 361);  // laser scans come without being asked for
}

TEST_F(ReplayTest, APluginMayHaveAVariableOfItsOwn) {
  const std::string arguments = "-p " HYBRID_EXAMPLE_PLUGIN
                                " --set plugins.classes=WallCompass --rawlog "
                                "/usr/share/mrpt/datasets/localization_demo.rawlog --set "
                                "solver.mode=";
  for (const char* mode : {"incremental", "batch", "fixed_lag", "filter"}) {
    const auto summary = summary_of(arguments + mode);
    EXPECT_EQ(summary["status"], "ok") << mode;  // without landmarks, but no dead reckoning
    EXPECT_EQ(summary["landmarks"], 0) << mode;
    EXPECT_EQ(summary["dropped"].size(), 1U) << summary["dropped"];  // unclear scans: none refused
    EXPECT_EQ(read_graph(at("out/graph.g2o")).values.size(), 37U) << mode;
    const std::string warning = summary["warnings"][0];
    EXPECT_NE(warning.find("wall direction"), std::string::npos) << warning;
  }
}

TEST_F(ReplayTest, WhatCannotBecomePartOfTheMapIsLeftOutAndTold) {
  const std::string arguments = "-c " + config("classed_demo.ini");
  const auto whole = summary_of(arguments);
  const auto summary =
      summary_of(arguments + " --set 'plugins.classes=ClassedBearingRangeKnownIds Refuses' -p " +
                     HYBRID_BAD_PLUGINS "/hybrid_bad_refuses.so",
                 2);
  EXPECT_EQ(summary["status"], "partial");
  EXPECT_EQ(summary["message"],
            "left out as not usable 4 times, first in step 2 of the log: observations dropped: not "
            "usable: a lens cap");
  EXPECT_EQ(summary["dropped"]["observations dropped: not usable"], 4);
  ASSERT_EQ(summary["warnings"].size(), 4U);
  EXPECT_NE(std::string(summary["warnings"][3]).find("Refuses has thrown"), std::string::npos);
  EXPECT_EQ(summary["keyframes"], whole["keyframes"]);
  EXPECT_EQ(summary["landmarks"], whole["landmarks"]);  // what is sound is all there
  EXPECT_NEAR(summary["objective"], whole["objective"], 1e-6);
}

TEST_F(ReplayTest, APluginThatEndsTheProgramIsAFailure) {
  expect_failure("-c " + config("classed_demo.ini") +
                     " --set plugins.classes=Refuses --set Refuses.end=exit -p " +
                     HYBRID_BAD_PLUGINS "/hybrid_bad_refuses.so",
                 "a library has ended the program");
}

TEST_F(ReplayTest, ASignalEndsAPluginThatWaitsForEver) {
  const std::string command =
      "timeout --foreground --signal=TERM 1 " HYBRID_BINARY_DIR
      "/bin/hybrid-replay --no-pictures -c " +
      config("classed_demo.ini") + " --set plugins.classes=Refuses --set Refuses.end=wait -p " +
      HYBRID_BAD_PLUGINS "/hybrid_bad_refuses.so -o " + at("out") + " 2> " + at("error.txt");
  EXPECT_EQ(run_shell(command).code, 124);  // of timeout, which waits for the end
  EXPECT_NE(read_file(folder / "error.txt").find("not noticed for 30 s"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "out/summary.json"));
}

TEST_F(ReplayTest, IsFullSmoothingToTheLastDigitUntilTheLogIsLong) {
  for (const char* name : {"classed_demo.ini", "slip_demo.ini", "kf_slam_6d_demo_da.ini"}) {
    const std::string command = "-c " + config(name) + " --set solver.mode=";
    ASSERT_EQ(run_replay(command + "bounded -o " + at("bounded")).code, 0) << name;
    ASSERT_EQ(run_replay(command + "incremental -o " + at("full")).code, 0) << name;
    for (const char* file : {"trajectory.tum", "landmarks.csv", "graph.g2o"}) {
      EXPECT_EQ(read_file(folder / "bounded" / file), read_file(folder / "full" / file)) << file;
    }
  }
}

// As short as it takes for keyframes to leave.
TEST_F(ReplayTest, ABoundedMapIsAsGoodAndAsSureAsThatOfFullSmoothing) {
  const std::string hidden = " --set sensor.ids=none --set plugins.classes=auto";
  for (const auto& [name, more] : {std::pair{"classed_demo.ini", std::string()},
                                   {"classed_demo.ini", hidden},
                                   {"classed_demo_3d.ini", std::string()},
                                   {"kf_slam_demo.ini", std::string()},
                                   {"slip_demo.ini", std::string()}}) {
    const std::string command = "-c " + config(name) + more;
    const auto full = summary_of(command);
    const auto bounded = summary_of(command + " --set solver.complete=60 --set solver.sightings=8");
    EXPECT_GE(bounded["plugins"]["keyframes_marginalized"], 50) << command;
    EXPECT_EQ(bounded["status"], "ok");
    EXPECT_EQ(bounded["dropped"], full["dropped"]);
    EXPECT_EQ(bounded["keyframes"], full["keyframes"]);
    EXPECT_EQ(bounded["landmarks"], full["landmarks"]);
    const auto& is = bounded["truth"];
    const auto& was = full["truth"];
    EXPECT_EQ(is.value("class_accuracy", -1.0), was.value("class_accuracy", -1.0));
    EXPECT_LT(is["trajectory"]["rmse_m"], 1.05 * was["trajectory"]["rmse_m"].get<double>());
    EXPECT_LT(is["landmarks"]["mean_m"], 1.05 * was["landmarks"]["mean_m"].get<double>());
    EXPECT_GT(is["nees_pose"], 0.8 * was["nees_pose"].get<double>());
    EXPECT_LT(is["nees_pose"], 1.25 * was["nees_pose"].get<double>());
  }
}

TEST_F(ReplayTest, HelpAndPrintConfigExplain) {
  const Ran help = run_replay("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.text.find("--rawlog"), std::string::npos);
  EXPECT_NE(help.text.find("Exit code"), std::string::npos);
  const Ran print = run_replay("--print-config -p " HYBRID_EXAMPLE_PLUGIN);
  EXPECT_EQ(print.code, 0);
  for (const char* part : {"[solver]", "mode = bounded", "[ClassedBearingRangeKnownIds]",
                           "[RobustBearingRange]", "huber_width = 3", "min_distance"}) {
    EXPECT_NE(print.text.find(part), std::string::npos) << part;
  }
  // What is printed for a config is a config of the same meaning.
  const Ran first = run_replay("--print-config -c " + config("kf_slam_demo.ini"));
  const std::string printed = write("printed.ini", first.text);
  EXPECT_EQ(run_replay("--print-config -c " + printed).text, first.text);
}

TEST_F(ReplayTest, ConfigIsRequired) {
  const Ran ran = run_replay("");
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.text.find("-c"), std::string::npos);
}

}  // namespace
}  // namespace hybrid
