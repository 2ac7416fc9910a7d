// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// hybrid-experiment as several processes of mpirun.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/apps/run_app.h"
#include "tests/apps/trial_rows.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

const std::string kMpirun = HYBRID_MPIRUN;

std::string mpirun(int ranks, const std::string& more = "") {
  return kMpirun + " --allow-run-as-root --oversubscribe -np " + std::to_string(ranks) + " " +
         more + " ";
}

/// A line of poses, each recognised three poses later.
std::string ladder(int poses) {
  std::ostringstream text;
  for (int k = 1; k < poses; ++k) {
    text << "EDGE_SE2 " << k - 1 << ' ' << k << " 1 0.01 0.02 400 0 0 400 0 2500\n";
    if (k >= 3) text << "EDGE_SE2 " << k - 3 << ' ' << k << " 3 0 0.05 400 0 0 400 0 2500\n";
  }
  return text.str();
}

class RanksTest : public ScratchFolder {
 protected:
  void SetUp() override {
    if (kMpirun.empty()) GTEST_SKIP() << "hybrid-experiment was built without MPI";
    write("a.g2o", ladder(40));
    write("b.g2o", ladder(60));
  }

  std::string config(const std::string& experiment) const {
    return write("e.ini", "[experiment]\ndata_dir = .\ngraphs = a b\nmethods = gnc dcs\n" +
                              experiment + "\n[a]\nfile = a.g2o\n[b]\nfile = b.g2o\n");
  }
  std::string command(const std::string& ini, const std::string& out) const {
    return "hybrid-experiment -c " + ini + " -o " + at(out);
  }
  std::map<std::string, std::string> rows(const std::string& out) const {
    return trial_rows(read(out + "/results.csv"));
  }
  /// Order of the trials in the ledger.
  std::string keys(const std::string& out) const {
    std::istringstream lines(read(out + "/results.csv"));
    std::string all;
    for (std::string line; std::getline(lines, line);) all += line.substr(0, line.find(',')) + "\n";
    return all;
  }
};

TEST_F(RanksTest, WriteWhatOneProcessWrites) {
  const std::string ini = config("outlier_rates = 0 0.4\ntrials = 4");
  ASSERT_EQ(run_app(command(ini, "one")).code, 0);
  for (const int ranks : {2, 4}) {
    const std::string out = "of" + std::to_string(ranks);
    const Ran ran = run_app(command(ini, out), mpirun(ranks));
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_EQ(rows(out), rows("one"));
    EXPECT_EQ(keys(out), keys("one"));
    EXPECT_EQ(read(out + "/a.png").substr(1, 3), "PNG");
  }
  EXPECT_EQ(rows("one").size(), 2U * 2U * 5U);
}

TEST_F(RanksTest, TellAnErrorOnce) {
  const Ran ran = run_app(command(config("tirals = 4"), "out"), mpirun(3));
  EXPECT_EQ(ran.code, 1) << ran.text;
  const std::size_t first = ran.text.find("hybrid-experiment: ");
  ASSERT_NE(first, std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find("did you mean 'trials'"), std::string::npos) << ran.text;
  EXPECT_EQ(ran.text.find("hybrid-experiment: ", first + 1), std::string::npos) << ran.text;
  // A file that fails when its turn comes: its trials fail, and no others.
  write("b.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n");
  const Ran parts = run_app(command(config("trials = 1"), "parts"), mpirun(2));
  EXPECT_EQ(parts.code, 2) << parts.text;
  EXPECT_NE(parts.text.find("b.g2o"), std::string::npos) << parts.text;
  const std::string ini = config("trials = 1");
  EXPECT_EQ(run_app(command(ini, "alone")).code, 2);
  EXPECT_EQ(rows("parts"), rows("alone"));
  EXPECT_EQ(rows("alone").size(), 4U);
  EXPECT_NE(read("alone/results.csv").find("a,,gnc,0,1,ok,"), std::string::npos);
  EXPECT_NE(read("alone/results.csv").find("b,,gnc,0,1,failed,"), std::string::npos);
}

/// The processes of a program whose command line holds this text, except mpirun itself, by their
/// rank.
std::map<int, pid_t> ranks_of(const std::string& text) {
  std::map<int, pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const auto content = [&](const char* file) {
      std::ifstream in(entry.path() / file, std::ios::binary);
      return std::string(std::istreambuf_iterator<char>(in), {});
    };
    if (content("cmdline").find(text) == std::string::npos) continue;
    const std::string environment = content("environ");
    const std::size_t rank = environment.find("OMPI_COMM_WORLD_RANK=");
    if (rank == std::string::npos) continue;
    // A trial has the environment of its rank: the rank is the older process.
    const int number = std::stoi(environment.substr(rank + 21));
    const pid_t pid = std::stoi(name);
    const auto [it, is_new] = found.emplace(number, pid);
    if (!is_new) it->second = std::min(it->second, pid);
  }
  return found;
}

/// Kills a rank once a few trials are in the ledger; returns what mpirun said.
Ran run_and_kill(const std::string& command, const std::string& launcher, const fs::path& ledger,
                 int rank) {
  Ran ran;
  std::atomic<bool> over = false;
  std::thread run([&] {
    ran = run_app(command, launcher);
    over = true;
  });
  const auto lines = [&] {
    std::ifstream in(ledger);
    return std::count(std::istreambuf_iterator<char>(in), {}, '\n');
  };
  while (lines() < 6 && !over) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto found = ranks_of(ledger.parent_path().string());
  const auto victim = found.find(rank);
  if (victim != found.end()) ::kill(victim->second, SIGKILL);
  run.join();
  EXPECT_NE(victim, found.end()) << "the run was over before " << rank << " could be killed";
  return ran;
}

TEST_F(RanksTest, ADeadOneLosesOnlyItsTrial) {
  const std::string ini = config("outlier_rates = 0.4\ntrials = 40\nrank_silence = 8");
  const std::string run = command(ini, "out");
  const Ran ran = run_and_kill(run, mpirun(3, "--enable-recovery"), folder / "out/results.csv", 2);
  EXPECT_NE(ran.text.find("rank 2 on "), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find("1 trials unfinished; run again"), std::string::npos) << ran.text;
  EXPECT_EQ(rows("out").size(), 160U);
  EXPECT_NE(read("out/summary.json").find("\"unfinished\": 1"), std::string::npos);
  // The same command, here without ranks, completes it.
  const Ran again = run_app(run);
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_NE(again.text.find("159 of 160 trials have been run before"), std::string::npos);
}

TEST_F(RanksTest, ADeadOneKeepsNoneOverLibfabric) {
  // A message to a dead rank waits for ever there.
  if (run_shell("ompi_info | grep -q 'MCA mtl: ofi'").code != 0) GTEST_SKIP() << "no libfabric";
  const std::string ini = config("outlier_rates = 0.4\ntrials = 40\nrank_silence = 3");
  const std::string run = command(ini, "out");
  const Ran ran = run_and_kill(run, mpirun(3, "--enable-recovery --mca pml cm --mca mtl ofi"),
                               folder / "out/results.csv", 2);
  const Ran again = run_app(run);  // the first one has ended
  EXPECT_EQ(again.code, 0) << again.text << ran.text;
  EXPECT_EQ(rows("out").size(), 160U);
}

TEST_F(RanksTest, GoOnAfterMpirunHasEndedAll) {
  const std::string ini = config("outlier_rates = 0.4\ntrials = 40");
  const std::string run = command(ini, "out");
  const Ran ran = run_and_kill(run, mpirun(3), folder / "out/results.csv", 1);
  EXPECT_NE(ran.code, 0) << ran.text;
  const std::string before = read("out/results.csv");
  const Ran again = run_app(run, mpirun(2));
  EXPECT_EQ(again.code, 0) << again.text;
  EXPECT_EQ(rows("out").size(), 160U);
  const std::string after = read("out/results.csv");
  std::istringstream lines(before.substr(0, before.rfind('\n') + 1));
  for (std::string line; std::getline(lines, line);) {
    EXPECT_NE(after.find(line + "\n"), std::string::npos) << line;
  }
}

TEST_F(RanksTest, NeedAProgramWithMpi) {
  // Slurm without its MPI plugin: two processes that do not find each other.
  const Ran ran = run_app(command(config("trials = 1"), "out"), "SLURM_STEP_NUM_TASKS=2 ");
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_NE(ran.text.find("2 processes were started that do not find each other"),
            std::string::npos)
      << ran.text;
  EXPECT_FALSE(fs::exists(at("out/results.csv")));
}

}  // namespace
}  // namespace hybrid
