// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// What a failing disk, a signal and kill -9 leave of the results of other programs than the replay.

#include <nlohmann/json.hpp>

#include "tests/apps/trial_rows.h"
#include "tests/faults/injection.h"

namespace hybrid {
namespace {

class ProgramFaults : public InjectionTest {
 protected:
  /// A round trip of so many poses with closures.
  std::string graph(const std::string& name, int poses) const {
    std::ostringstream text;
    for (int i = 1; i < poses; ++i) {
      text << "EDGE_SE2 " << i - 1 << ' ' << i << " 1 0 0.5 100 0 0 100 0 100\n";
      if (i % 13 == 0) text << "EDGE_SE2 " << i - 13 << ' ' << i << " 0 0 0.2 9 0 0 9 0 9\n";
      if (i % 25 == 1) text << "EDGE_PRIOR_SE2 " << i - 1 << " 0 0 0 .1 0 0 .1 0 .1\n";
    }
    return write(name, text.str());
  }
  /// Files without those that hold times, and without hidden ones.
  Files timeless(const std::string& name) const {
    Files found = files(name);
    for (auto it = found.begin(); it != found.end();) {
      const bool left_out = it->first[0] == '.' || it->first == "summary.json" ||
                            it->first == "steps.csv" || it->first == "graph.png";
      it = left_out ? found.erase(it) : std::next(it);
    }
    return found;
  }
  /// Each of some calls of the disk of `renewing` fails over what `first` wrote to `name`.
  void expect_old_or_new(const std::string& name, const std::string& first,
                         const std::string& renewing) const {
    ASSERT_EQ(run_app(renewing).code, 0);
    const Files renewed = timeless(name);
    std::filesystem::remove_all(folder / name);
    ASSERT_EQ(run_app(first).code, 0);
    const Files old = files(name), old_timeless = timeless(name);
    ASSERT_NE(old_timeless, renewed);
    for (const char* how : {"once", "9"}) {
      Fault fault{"disk", how};
      set_files(name, old);
      const long all = count({"disk", "once"}, renewing);
      for (const long number : numbers(all, 25)) {
        fault.at = number;
        set_files(name, old);
        const Ran ran = run_with(fault, renewing);
        const Files after = timeless(name);
        if (ran.code == 0) {
          EXPECT_EQ(after, renewed) << to_string(fault);
        }
        if (ran.code == 1) {
          EXPECT_EQ(after, old_timeless) << to_string(fault) << ran.text;
        }
        if (ran.code == 1) {
          EXPECT_EQ(files(name).count("summary.json"), old.count("summary.json"));
        }
        EXPECT_TRUE(ran.code == 0 || ran.code == 1 || ran.code == 128 + 9)
            << to_string(fault) << ": " << ran.code << ran.text;
        // The next one clears what is left, and completes what was begun.
        EXPECT_EQ(run_app(renewing).code, 0);
        EXPECT_EQ(timeless(name), renewed) << to_string(fault);
        for (const FolderEntry& entry : entries_of(folder / name)) {
          EXPECT_NE(entry.name[0], '.') << entry.name << " " << to_string(fault);
        }
      }
    }
  }
};

TEST_F(ProgramFaults, PoseGraph) {
  const std::string out = " --picture-format svg -o " + at("out");  // PNG takes most of the time
  expect_old_or_new("out", "hybrid-pgo " + graph("a.g2o", 30) + out,
                    "hybrid-pgo " + graph("b.g2o", 40) + out);
}

TEST_F(ProgramFaults, Simulation) {
  write("a.ini", "[world]\nlandmarks = 4\n[path]\nlaps = 1\nstep = 4\n[slip]\nstart = 0.2\n");
  write("b.ini", "[world]\nlandmarks = 5\n[path]\nlaps = 1\nstep = 3\n");
  const std::string out = " -o " + at("logs/log.rawlog");
  expect_old_or_new("logs", "hybrid-simulate -c " + at("a.ini") + out,
                    "hybrid-simulate -c " + at("b.ini") + out);
}

TEST_F(ProgramFaults, AnImportThatIsStoppedLeavesNothing) {
  std::string odometry = "time,x,y,yaw\n";
  for (int i = 0; i < 50; ++i) odometry += std::to_string(i) + "," + std::to_string(i) + ",0,0\n";
  const std::string command =
      "hybrid-import csv --odometry " + write("o.csv", odometry) + " --detections " +
      write("d.csv", "time,range,yaw,class,score,id\n1,5,0,tree,0.9,1\n30,4,0,tree,0.9,2\n") +
      " -o " + at("logs/log.rawlog");
  Fault fault{"memory", "2"};
  const long all = count({"memory", "once"}, command);
  std::filesystem::remove_all(folder / "logs");
  std::size_t stopped = 0;
  for (const long number : numbers(all, 20)) {
    fault.at = number;
    const Ran ran = run_with(fault, command);
    if (ran.code == 0) {  // all had been read
      std::filesystem::remove_all(folder / "logs");
      continue;
    }
    ++stopped;
    EXPECT_EQ(ran.code, 130) << ran.text;
    EXPECT_FALSE(name_exists(folder / "logs")) << to_string(fault);
  }
  EXPECT_GT(stopped, 0U);
}

TEST_F(ProgramFaults, AnOnlinePoseGraphThatIsStoppedWritesWhatItHas) {
  const int poses = 300;  // most allocations are those of the steps
  const std::string file = graph("a.g2o", poses);
  for (const char* trusted : {"all", "odometry"}) {
    const std::string command =
        "hybrid-pgo --online --trusted " + std::string(trusted) + " " + file + " -o " + at("out");
    Fault fault{"memory", "15"};
    const long all = count({"memory", "once"}, command);
    std::size_t stopped = 0;
    for (const long number : numbers(all, 15)) {
      fault.at = number;
      std::filesystem::remove_all(folder / "out");
      const Ran ran = run_with(fault, command);
      if (ran.code == 0) continue;
      EXPECT_EQ(ran.code, 143) << ran.text;
      if (!name_exists(folder / "out/summary.json")) continue;  // before the first pose
      ++stopped;
      const auto summary = nlohmann::json::parse(read("out/summary.json"));
      EXPECT_EQ(summary["status"], "interrupted");
      EXPECT_LT(summary["poses"], poses);
      // What it wrote is a graph of its own.
      EXPECT_EQ(run_app("hybrid-pgo " + at("out/graph.g2o") + " -o " + at("again")).code, 0);
      const auto again = nlohmann::json::parse(read("again/summary.json"));
      EXPECT_EQ(again["poses"], summary["poses"]);
      EXPECT_EQ(again["inliers"].get<int>() + again["outliers"].get<int>(),
                summary["inliers"].get<int>() + summary["outliers"].get<int>());
    }
    EXPECT_GT(stopped, 0U) << trusted;
  }
}

class ExperimentFaults : public ProgramFaults {
 protected:
  std::string command(const std::string& out) const {
    write("e.ini",
          "[experiment]\ndata_dir = .\ngraphs = ring\nmethods = gnc dcs\noutlier_rates = 0.3\n"
          "trials = 6\n[ring]\nfile = ring.g2o\nstart = odometry\n");
    graph("ring.g2o", 40);
    return "hybrid-experiment -j 2 -c " + at("e.ini") + " -o " + at(out);
  }
  std::map<std::string, std::string> rows(const std::string& out) const {
    return trial_rows(read(out + "/results.csv"));
  }
};

TEST_F(ExperimentFaults, LosesAndDoublesNoTrialHoweverItIsStopped) {
  ASSERT_EQ(run_app(command("whole")).code, 0);
  const Files whole = rows("whole");
  ASSERT_EQ(whole.size(), 12U);
  for (const Fault& kind :
       {Fault{"disk", "once"}, Fault{"disk", "9"}, Fault{"memory", "2"}, Fault{"memory", "15"}}) {
    Fault fault = kind;
    std::filesystem::remove_all(folder / "out");
    const long all = count({fault.calls, "once"}, command("out"));
    for (const long number : numbers(all, 10)) {
      fault.at = number;
      std::filesystem::remove_all(folder / "out");
      const Ran ran = run_with(fault, command("out"));
      if (fault.how == "once") {
        EXPECT_TRUE(ran.code == 0 || ran.code == 1) << to_string(fault) << ran.text;
      } else {
        EXPECT_TRUE(ran.code == 0 || ran.code == 128 + std::stoi(fault.how))
            << to_string(fault) << ran.code << ran.text;
      }
      for (const auto& [trial, row] : rows("out")) EXPECT_EQ(row, whole.at(trial));
      const Ran again = run_app(command("out"));
      EXPECT_EQ(again.code, 0) << to_string(fault) << again.text;
      EXPECT_EQ(rows("out"), whole) << to_string(fault);
    }
  }
}

}  // namespace
}  // namespace hybrid
