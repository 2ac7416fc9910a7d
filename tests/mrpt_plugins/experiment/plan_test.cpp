// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/plan.h"

#include <filesystem>
#include <set>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class PlanTest : public ScratchFolder {
 protected:
  PlanTest() {
    write("a.g2o", "VERTEX_SE2 0 0 0 0\n");
    write("b_1.g2o", "VERTEX_SE2 0 0 0 0\n");
    write("b_2.g2o", "VERTEX_SE2 0 0 0 0\n");
  }
  static ExperimentPlan plan_of(const std::string& text) {
    IniFile ini(text, "test.ini");
    return read_plan(ini);
  }
  ExperimentPlan plan(const std::string& experiment, const std::string& rest = "") const {
    return plan_of("[experiment]\ndata_dir = " + folder.string() + "\n" + experiment + "\n" + rest);
  }
  void expect_error(const std::string& experiment, const std::string& rest,
                    const std::string& part) const {
    try {
      plan(experiment, rest);
      ADD_FAILURE() << "no error: " << part;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
};

TEST_F(PlanTest, CountsTrials) {
  const ExperimentPlan p =
      plan("graphs = a b\nmethods = lm gnc\noutlier_rates = 0 0.5\ntrials = 3\nfirst_seed = 10",
           "[a]\nfile = a.g2o\n[b]\nfile = b_{variant}.g2o\nvariants = 1 2\n");
  const auto trials = trials_of(p);
  // Without false closures the seed tells nothing: one trial.
  EXPECT_EQ(trials.size(), 3u * (1 + 3) * 2);
  std::set<std::string> keys;
  for (const Trial& trial : trials) keys.insert(trial.key());
  EXPECT_EQ(keys.size(), trials.size());
  EXPECT_EQ(trials.front().key(), "a//lm/0/10");
  EXPECT_EQ(trials.back().key(), "b/2/gnc/0.5/12");
}

TEST_F(PlanTest, KeepsTheGraphsThatAreWanted) {
  const std::string graphs = "[a]\nfile = a.g2o\n[b]\nfile = b_{variant}.g2o\nvariants = 1 2\n";
  const ExperimentPlan all = plan("graphs = a b\nmethods = lm", graphs);
  const ExperimentPlan part = plan("graphs = a b\nonly = b\nmethods = lm", graphs);
  ASSERT_EQ(part.graphs.size(), 1u);
  EXPECT_EQ(part.graphs[0].name, "b");
  EXPECT_EQ(trials_of(part).size(), 2u);
  for (const auto& [key, value] : part.fingerprint) EXPECT_EQ(all.fingerprint.at(key), value);
  expect_error("graphs = a b\nonly = c", graphs, "none of a, b");
}

TEST_F(PlanTest, ReplaysEveryLog) {
  write("map.ini", "[input]\n");
  write("monday.rawlog", "1");
  write("tuesday.rawlog", "2");
  const auto replays = [&](const std::string& section) {
    return plan_of(
        "[experiment]\nkind = replay\nreplays = fleet\nmethods = a b\ntrials = 3\n"
        "first_seed = 4\n[fleet]\nconfig = " +
        at("map.ini") + "\n" + section + "[a]\n[b]\n");
  };
  const std::string logs = "rawlogs = " + at("monday.rawlog") + " " + at("tuesday.rawlog") + "\n";
  const ExperimentPlan both = replays(logs);
  std::vector<std::string> keys;
  for (const Trial& trial : trials_of(both)) keys.push_back(trial.key());
  EXPECT_EQ(keys, (std::vector<std::string>{"fleet/monday/a/0/4", "fleet/monday/b/0/4",
                                            "fleet/tuesday/a/0/4", "fleet/tuesday/b/0/4"}));
  EXPECT_EQ(trials_of(replays("")).front().key(), "fleet//a/0/4");
  // Another log adds trials; another content of a log makes others.
  const ExperimentPlan one = replays("rawlogs = " + at("monday.rawlog") + "\n");
  for (const auto& [name, value] : one.fingerprint) EXPECT_EQ(both.fingerprint.at(name), value);
  write("monday.rawlog", "3");
  EXPECT_NE(replays(logs).fingerprint, both.fingerprint);
  write("simulate.ini", "");
  const std::string start = "kind = replay\nreplays = r\n";
  const std::string config = "[r]\nconfig = " + at("map.ini") + "\n";
  expect_error(start, config + "rawlogs = " + at("absent.rawlog"), "absent.rawlog");
  expect_error(start, config + "simulate = " + at("simulate.ini") + "\n" + logs, "'simulate'");
  std::filesystem::create_directories(folder / "other");
  write("other/monday.rawlog", "5");
  expect_error(start, config + "rawlogs = " + at("monday.rawlog") + " " + at("other/monday.rawlog"),
               "'monday' twice");
}

TEST_F(PlanTest, FingerprintSeesSettingsAndContents) {
  const std::string rest = "[a]\nfile = a.g2o\n";
  const auto before = plan("graphs = a\nmethods = gnc", rest).fingerprint;
  EXPECT_EQ(plan("graphs = a\nmethods = gnc lm\ntrials = 4\njobs = 2\noutlier_rates = 0.1", rest)
                .fingerprint,
            before);
  EXPECT_NE(plan("graphs = a\nmethods = gnc\ntime_limit = 4", rest).fingerprint, before);
  EXPECT_NE(plan("graphs = a\nmethods = gnc", rest + "[gnc]\ngrowth = 1.2\n").fingerprint, before);
  write("a.g2o", "VERTEX_SE2 0 0 0 1\n");
  EXPECT_NE(plan("graphs = a\nmethods = gnc", rest).fingerprint, before);
}

TEST_F(PlanTest, ErrorsNameTheKey) {
  const std::string a = "[a]\nfile = a.g2o\n";
  expect_error("graphs = a\nmethods = gnk", a, "did you mean 'gnc'");
  expect_error("graphs = a a", a, "twice");
  expect_error("methods = lm", "", "graphs");
  expect_error("graphs = c", "[c]\nfile = c.g2o\n", "c.g2o");
  expect_error("graphs = a\noutlier_rates = 1", a, "outlier_rates");
  expect_error("graphs = a\ntrials = 0", a, "trials");
  expect_error("graphs = a\nbogus = 1", a, "bogus");
  expect_error("graphs = a", a + "[stray]\nx = 1\n", "stray");
  expect_error("graphs = a", "[a]\nfile = a.g2o\nvariants = 1 2\n", "{variant}");
  expect_error("graphs = a", "[a]\nfile = b_{variant}.g2o\n", "{variant}");
  expect_error("graphs = a", "[a]\nfile = a.g2o\nlabel_distance = 1\n", "label_distance");
  expect_error("kind = replay", "", "replays");
  expect_error("kind = replay\nreplays = r", "[r]\nconfig = absent.ini\n", "absent.ini");
}

TEST_F(PlanTest, OldNamesOfMethodsStandForTheNewOnes) {
  const std::string a = "[a]\nfile = a.g2o\n";
  IniFile ini("[experiment]\ndata_dir = " + folder.string() +
                  "\ngraphs = a\nmethods = gnc escape consistency-escape\n" + a,
              "test.ini");
  const ExperimentPlan p = read_plan(ini);
  EXPECT_EQ(p.methods, (std::vector<std::string>{"gnc", "selection", "consistency-selection"}));
  ASSERT_EQ(ini.warnings().size(), 2u);
  EXPECT_EQ(ini.warnings()[0],
            "test.ini:4:1: [experiment] methods names 'escape', which is now called 'selection'");
  expect_error("graphs = a\nmethods = escape selection", a, "'selection' twice");
}

TEST_F(PlanTest, SettingsOfMethodsAreRead) {
  const ExperimentPlan p =
      plan("graphs = a\nmethods = selection",
           "[a]\nfile = a.g2o\n[selection]\nmargin = 3\n[online_selection]\ndecisive = 7\n"
           "[mixture]\nnull_hypothesis = 4.5\ninlier_weight = 0.7\n[gnc]\nmax_rounds = 7\n");
  const MethodOptions& o = p.method_options;
  EXPECT_EQ(o.portfolio.selection.margin, 3);
  EXPECT_EQ(o.online.selection.margin, 3);
  EXPECT_EQ(o.online.decisive, 7);
  EXPECT_EQ(o.gnc.max_rounds, 7);
  EXPECT_EQ(o.gnc.mixture.null_hypothesis, 4.5);
  EXPECT_DOUBLE_EQ(o.online.mixture.outlier_weight, 0.3);
  EXPECT_EQ(o.gnc.solver.threads, 1);
  EXPECT_EQ(o.online.selection.solver.threads, 1);
  expect_error("graphs = a", "[a]\nfile = a.g2o\n[mixture]\nnull_hypothesis = 1 2\n",
               "null_hypothesis");
}

TEST_F(PlanTest, DocumentsItself) {
  IniFile ini;
  read_plan(ini);
  const std::string text = ini.documentation();
  for (const char* word : {"[experiment]", "outlier_rates", "[gnc]", "first_seed"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
}

}  // namespace
}  // namespace hybrid
