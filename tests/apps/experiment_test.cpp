// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/io/write_graph.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "tests/apps/run_app.h"
#include "tests/apps/trial_rows.h"
#include "tests/support/pose_graph_worlds.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

Ran run(const std::string& arguments, const std::string& before = "") {
  return run_app("hybrid-experiment " + arguments, before);
}

/// Laps around a square of eight poses, each recognised a lap later.
std::string laps_graph(int laps) {
  const auto truth = [](int k) { return SE2(k % 2, 0.2 * (k % 3), 0.3 * k); };
  std::ostringstream text;
  const auto edge = [&](int i, int j, const SE2& z) {
    text << "EDGE_SE2 " << i << ' ' << j << ' ' << z.x() << ' ' << z.y() << ' ' << z.angle()
         << " 400 0 0 400 0 2500\n";
  };
  for (int k = 1; k < 8 * laps; ++k) {
    const SE2 z = truth(k - 1).between(truth(k));
    edge(k - 1, k, z * SE2(0.01, 0.005 * (k % 5), 0.01));
    if (k >= 8) edge(k - 8, k, truth(k - 8).between(truth(k)));
  }
  return text.str();
}

class Experiment : public ScratchFolder {
 protected:
  Experiment() { write("laps.g2o", laps_graph(4)); }

  /// An INI for the graph of laps.
  std::string config(const std::string& experiment) const {
    return write("e.ini", "[experiment]\ndata_dir = .\ngraphs = laps\n" + experiment +
                              "\n[laps]\nfile = laps.g2o\nstart = odometry\n");
  }
  std::map<std::string, std::string> rows(const std::string& out) const {
    return trial_rows(read(out + "/results.csv"));
  }
};

TEST_F(Experiment, ComparesMethods) {
  const std::string ini = config(
      "methods = odometry oracle lm gnc gnc-gm dcs switchable max-mixture consistency "
      "consistency-gnc\noutlier_rates = 0 0.4\ntrials = 2\n");
  const Ran ran = run("-c " + ini + " -o " + at("out"));
  EXPECT_EQ(ran.code, 0) << ran.text;
  EXPECT_EQ(rows("out").size(), 10u * 3u);
  for (const char* name : {"laps.png", "reliability_gnc.png"}) {
    EXPECT_EQ(read(std::string("out/") + name).substr(1, 3), "PNG") << name;
  }
  EXPECT_EQ(read("out/summary.csv").rfind("graph,variant,method,outlier_rate,trials,", 0), 0u);
  EXPECT_NE(read("out/summary.txt").find("switchable"), std::string::npos);
  EXPECT_NE(ran.text.find("100 %"), std::string::npos);
  // What knows the truth is at the optimum of the clean graph; what believes lies is not.
  for (const auto& [key, row] : rows("out")) {
    const double ate = std::stod(row.substr(row.find(",ok,") + 4));
    if (key.rfind("laps//oracle", 0) == 0) {
      EXPECT_LT(ate, 1e-6) << row;
    }
    if (key.rfind("laps//lm/0.4", 0) == 0) {
      EXPECT_GT(ate, 0.05) << row;
    }
    if (key.rfind("laps//gnc/0.4", 0) == 0) {
      EXPECT_LT(ate, 0.05) << row;
    }
  }
}

TEST_F(Experiment, RunsAPartOfAnIni) {
  const std::string ini = config("methods = gnc dcs\noutlier_rates = 0 0.3\ntrials = 4\n");
  const std::string part =
      " --set experiment.methods=dcs --set experiment.trials=2 -o " + at("out");
  ASSERT_EQ(run("-c " + ini + part).code, 0);
  EXPECT_EQ(rows("out").size(), 3u);  // without false closures every trial is the same
  ASSERT_EQ(run("-c " + ini + " -o " + at("out")).code, 0);
  EXPECT_EQ(rows("out").size(), 10u);
}

TEST_F(Experiment, IsTheSameOnAnyNumberOfCores) {
  const std::string ini = config("methods = gnc dcs\noutlier_rates = 0.3\ntrials = 4\n");
  ASSERT_EQ(run("-j 1 -c " + ini + " -o " + at("one")).code, 0);
  ASSERT_EQ(run("-j 3 -c " + ini + " -o " + at("three")).code, 0);
  EXPECT_EQ(rows("one"), rows("three"));
  EXPECT_EQ(rows("one").size(), 8u);
}

TEST_F(Experiment, GoesOnWhereItWasKilled) {
  const std::string ini = config("methods = gnc\noutlier_rates = 0.5\ntrials = 400\n");
  run("-c " + ini + " -o " + at("out"), "timeout -s KILL 0.6 ");
  std::string before = read("out/results.csv");
  before.resize(before.rfind('\n') + 1);
  const auto done = std::count(before.begin(), before.end(), '\n') - 1;
  EXPECT_LT(done, 400);
  std::ofstream(folder / "out/results.csv", std::ios::app) << "laps//gnc/0.5/40";  // cut off
  const Ran again = run("-c " + ini + " -o " + at("out"));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(rows("out").size(), 400u);
  if (done > 0) {
    EXPECT_NE(again.text.find(std::to_string(done) + " of 400 trials have been run before"),
              std::string::npos)
        << again.text;
  }
  // What had been run stays to the last digit of its times.
  const std::string after = read("out/results.csv");
  std::istringstream lines(before);
  for (std::string line; std::getline(lines, line);) {
    EXPECT_NE(after.find(line + "\n"), std::string::npos) << line;
  }
  const Ran third = run("-c " + ini + " -o " + at("out"));
  EXPECT_EQ(third.code, 0) << third.text;
  EXPECT_EQ(read("out/results.csv"), after);
}

TEST_F(Experiment, NoticesOtherSettingsInTheSameFolder) {
  const std::string start = "methods = gnc\noutlier_rates = 0.3\n";
  ASSERT_EQ(run("-c " + config(start + "trials = 2\n") + " -o " + at("out")).code, 0);
  // More of the same is welcome.
  ASSERT_EQ(run("-c " + config(start + "trials = 3\n") + " -o " + at("out")).code, 0);
  EXPECT_EQ(rows("out").size(), 3u);
  const std::string results = read("out/results.csv");
  const Ran summary = run("--summary -c " + config(start + "trials = 9\n") + " -o " + at("out"));
  EXPECT_EQ(summary.code, 0) << summary.text;
  EXPECT_EQ(read("out/results.csv"), results);
  const Ran changed =
      run("-c " + config(start + "trials = 3\n[gnc]\ngrowth = 2\n") + " -o " + at("out"));
  EXPECT_EQ(changed.code, 1);
  EXPECT_NE(changed.text.find("gnc.growth was"), std::string::npos) << changed.text;
  const std::string ini = config(start + "trials = 3\n");
  write("laps.g2o", laps_graph(3));
  const Ran file = run("-c " + ini + " -o " + at("out"));
  EXPECT_EQ(file.code, 1);
  EXPECT_NE(file.text.find("laps.g2o"), std::string::npos) << file.text;
  EXPECT_EQ(read("out/results.csv"), results);
}

TEST_F(Experiment, EndsTrialsThatTakeTooLong) {
  const Ran ran = run("-c " +
                      config("methods = gnc\noutlier_rates = 0.99\ntrials = 1\n"
                             "time_limit = 0.001\n") +
                      " -o " + at("out"));
  EXPECT_EQ(ran.code, 0) << ran.text;
  EXPECT_NE(read("out/results.csv").find(",timeout,0.001,0.001,"), std::string::npos)
      << read("out/results.csv");
}

TEST_F(Experiment, RunsAgainWhatTheMachineKeptFromEnding) {
  const std::string ini = write("replays.ini",
                                "[experiment]\nkind = replay\nreplays = demo\n"
                                "methods = batch wrong\n[demo]\nconfig = " HYBRID_SOURCE_DIR
                                "/config/classed_demo.ini\n"
                                "[batch]\nset = solver.mode=batch\n"
                                "[wrong]\nset = solver.mode=none_such\n");
  const std::string command = "-c " + ini + " -o " + at("out");
  {
    // Somebody writes into the folder of a trial.
    const OutputDirectory held(folder / "out/trials/demo__batch_0_1");
    const Ran ran = run(command);
    EXPECT_EQ(ran.code, 2) << ran.text;
    EXPECT_NE(ran.text.find("1 trials failed, 1 trials unfinished; run again"), std::string::npos)
        << ran.text;
  }
  EXPECT_NE(read("out/results.csv").find(",batch,0,1,unfinished,"), std::string::npos);
  auto summary = nlohmann::json::parse(read("out/summary.json"));
  EXPECT_EQ(summary["status"], "partial");
  EXPECT_EQ(summary["trials"]["unfinished"], 1);
  // What failed for reasons of its own stays a result.
  const Ran again = run(command);
  EXPECT_EQ(again.code, 2) << again.text;
  EXPECT_NE(again.text.find("1 of 2 trials have been run before"), std::string::npos) << again.text;
  EXPECT_NE(read("out/results.csv").find(",batch,0,1,ok,"), std::string::npos);
  EXPECT_EQ(rows("out").size(), 2U);
  summary = nlohmann::json::parse(read("out/summary.json"));
  EXPECT_EQ(summary["trials"]["failed"], 1);
  EXPECT_EQ(summary["trials"]["ok"], 1);
  const Ran third = run(command);
  EXPECT_NE(third.text.find("2 of 2 trials have been run before"), std::string::npos) << third.text;
  const Ran retry = run("--retry " + command);
  EXPECT_NE(retry.text.find("1 of 2 trials have been run before"), std::string::npos) << retry.text;
  EXPECT_EQ(rows("out").size(), 2U);
}

TEST_F(Experiment, TellsThatResultsAreOfAnotherVersion) {
  const std::string command = "-c " + config("methods = gnc\n") + " -o " + at("out");
  const Ran first = run(command);
  ASSERT_EQ(first.code, 0) << first.text;
  EXPECT_EQ(first.text.find("version"), std::string::npos) << first.text;
  std::string settings = read("out/settings.txt");
  const std::size_t at_version = settings.find("version=") + 8;
  const std::string version =
      settings.substr(at_version, settings.find('\n', at_version) - at_version);
  settings.replace(at_version, version.size(), "0.0.9");
  write("out/settings.txt", settings);
  const Ran second = run(command);
  EXPECT_EQ(second.code, 0) << second.text;
  EXPECT_NE(second.text.find("has results of version 0.0.9, and this is " + version),
            std::string::npos)
      << second.text;
  EXPECT_NE(read("out/settings.txt").find("version=0.0.9; " + version), std::string::npos);
}

TEST_F(Experiment, WritesASummaryAndKeepsItsLedgerFromOtherPrograms) {
  ASSERT_EQ(run("-c " + config("methods = gnc\n") + " -o " + at("out")).code, 0);
  const auto summary = nlohmann::json::parse(read("out/summary.json"));
  EXPECT_EQ(summary["status"], "ok");
  EXPECT_EQ(summary["trials"]["ok"], 1);
  ASSERT_EQ(summary["inputs"].size(), 2U);  // INI and graph
  EXPECT_EQ(summary["inputs"][1]["path"], at("laps.g2o"));
  const std::string ledger = read("out/results.csv");
  EXPECT_EQ(run_app("hybrid-pgo " + at("laps.g2o") + " -o " + at("out")).code, 0);
  EXPECT_EQ(read("out/results.csv"), ledger);
  EXPECT_FALSE(fs::exists(at("out/laps.png")));
}

TEST_F(Experiment, BadInput) {
  const auto expect_failure = [&](const std::string& arguments, const std::string& part) {
    const Ran ran = run(arguments + " -o " + at("none"));
    EXPECT_EQ(ran.code, 1) << ran.text;
    EXPECT_NE(ran.text.find(part), std::string::npos) << ran.text;
    EXPECT_FALSE(fs::exists(at("none/results.csv")));
  };
  expect_failure("-c " + at("absent.ini"), "absent.ini");
  expect_failure("-c " + config("metods = gnc"), "metods");
  expect_failure("-c " + config("methods = gnc\ntrials = -1"), "trials");
  expect_failure("", "-c");
  // A graph of two parts fails when its turn comes, and says so.
  write("laps.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n");
  const Ran parts = run("-c " + config("methods = gnc") + " -o " + at("parts"));
  EXPECT_EQ(parts.code, 2);
  EXPECT_NE(parts.text.find("laps.g2o"), std::string::npos) << parts.text;
  // Without closures nothing can be false, and all methods are odometry.
  write("laps.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const Ran bare = run("-c " + config("methods = gnc lm consistency\noutlier_rates = 0.5") +
                       " -o " + at("bare"));
  EXPECT_EQ(bare.code, 0) << bare.text;
}

TEST_F(Experiment, RepairsInformationWhereItIsTold) {
  std::string text = laps_graph(3);
  const std::string sound = " 400 0 0 400 0 2500\n";
  text.replace(text.find(sound), sound.size(), " 400 0 0 400 0 -1e-9\n");
  write("laps.g2o", text);
  const std::string ini = config("methods = lm\noutlier_rates = 0");
  EXPECT_EQ(run("-c " + ini + " -o " + at("as_it_is")).code, 2);
  EXPECT_NE(read("as_it_is/results.csv").find("not positive definite"), std::string::npos);
  const Ran repaired =
      run("-c " + ini + " --set laps.repair_information=yes --set laps.start=tree -o " +
          at("repaired"));
  EXPECT_EQ(repaired.code, 0) << repaired.text;
}

// From chained odometry a sphere of noisy rotations ends far above its optimum.
TEST_F(Experiment, TheReferenceIsTheBestThatAnyStartLeadsTo) {
  worlds::World world = worlds::sphere(10, 30, {0.1, 0.3}, 11);
  world.graph.values = Values();
  write_g2o(at("laps.g2o"), world.graph);
  const std::string ini = config("methods = oracle\noutlier_rates = 0");
  const auto error = [&](const std::string& start) {
    const Ran ran = run("-c " + ini + " --set laps.start=" + start + " -o " + at(start));
    EXPECT_EQ(ran.code, 0) << ran.text;
    const std::string row = rows(start).begin()->second;
    return std::stod(row.substr(row.find(",ok,") + 4));
  };
  EXPECT_GT(error("odometry"), 0.1);
  EXPECT_LT(error("chordal"), 1e-3);
}

TEST_F(Experiment, PrintsItsConfiguration) {
  const Ran all = run("--print-config");
  EXPECT_EQ(all.code, 0);
  EXPECT_NE(all.text.find("outlier_rates"), std::string::npos) << all.text;
  EXPECT_EQ(run("--help").code, 0);
  const Ran one = run("--print-config -c " + config("trials = 7"));
  EXPECT_NE(one.text.find("trials = 7"), std::string::npos) << one.text;
  // It is a valid INI by itself.
  const Ran again = run("--print-config -c " + write("again.ini", one.text));
  EXPECT_EQ(again.code, 0) << again.text;
}

TEST_F(Experiment, ReplaysLogs) {
  const std::string root = HYBRID_SOURCE_DIR "/config/";
  const std::string ini = write("replays.ini",
                                "[experiment]\nkind = replay\nreplays = demo\n"
                                "methods = incremental batch\ntrials = 2\n"
                                "[demo]\nconfig = " +
                                    root + "classed_demo.ini\nsimulate = " + root +
                                    "simulate_classed_demo.ini\n"
                                    "[incremental]\n[batch]\nset = solver.mode=batch\n");
  const Ran ran = run("-c " + ini + " -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.text << read("out/results.csv");
  EXPECT_EQ(rows("out").size(), 4u);
  EXPECT_EQ(read("out/objective.png").substr(1, 3), "PNG");
  EXPECT_NE(read("out/summary.csv").find("truth.landmarks.mean_m_median"), std::string::npos);
}

}  // namespace
}  // namespace hybrid
