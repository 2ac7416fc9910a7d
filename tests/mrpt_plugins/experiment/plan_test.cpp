// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/plan.h"

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
  ExperimentPlan plan(const std::string& experiment, const std::string& rest = "") const {
    IniFile ini("[experiment]\ndata_dir = " + folder.string() + "\n" + experiment + "\n" + rest,
                "test.ini");
    return read_plan(ini);
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
