// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/methods/robust_methods.h"
#include "tests/apps/run_app.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

Ran run(const std::string& arguments) {
  return run_app("hybrid-pgo " + arguments);
}

std::string data_dir() {
  const char* environment = std::getenv("HYBRID_DATA_DIR");
  return environment != nullptr ? environment : HYBRID_DATA_DIR;
}

std::string edge(int i, int j, const SE2& z) {
  std::ostringstream line;
  line << "EDGE_SE2 " << i << ' ' << j << ' ' << z.x() << ' ' << z.y() << ' ' << z.angle()
       << " 400 0 0 400 0 2500\n";
  return line.str();
}

/// A robot that drives `laps` times around a square of eight poses, measures its way with a bias
/// and recognises each pose of the lap before.
std::string laps_graph(int laps) {
  const auto truth = [](int k) { return SE2(k % 2, 0.2 * (k % 3), 0.3 * k); };
  std::string text;
  for (int k = 1; k < 8 * laps; ++k) {
    const SE2 z = truth(k - 1).inverse() * truth(k);
    text += edge(k - 1, k, z * SE2(0.01, 0.005 * (k % 5), 0.01));
    if (k >= 8) text += edge(k - 8, k, truth(k - 8).inverse() * truth(k));
  }
  return text;
}

class Pgo : public ::testing::Test {
 protected:
  Pgo() { fs::create_directories(folder); }
  ~Pgo() override { fs::remove_all(folder); }

  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return at(name);
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  nlohmann::json summary(const std::string& out) const {
    return nlohmann::json::parse(read(out + "/summary.json"));
  }
  int lines(const std::string& name) const {
    const std::string text = read(name);
    return static_cast<int>(std::count(text.begin(), text.end(), '\n'));
  }
  /// Runs batch and online and returns the two summaries.
  std::pair<nlohmann::json, nlohmann::json> both(const std::string& graph) const {
    const Ran batch = run(graph + " --method lm -o " + at("batch"));
    EXPECT_EQ(batch.code, 0) << batch.text;
    const Ran online = run(graph + " --online -o " + at("online"));
    EXPECT_EQ(online.code, 0) << online.text;
    return {summary("batch"), summary("online")};
  }
  /// The program fails with one line that holds `part`, and writes nothing.
  void expect_failure(const std::string& arguments, const std::string& part) const {
    const Ran result = run(arguments + " -o " + at("none"));
    EXPECT_EQ(result.code, 1) << arguments;
    EXPECT_NE(result.text.find(part), std::string::npos) << result.text;
    EXPECT_EQ(std::count(result.text.begin(), result.text.end(), '\n'), 1) << result.text;
    EXPECT_FALSE(fs::exists(at("none/graph.g2o")));
  }

  const fs::path folder = fs::temp_directory_path() / ("hybrid_pgo_" + std::to_string(getpid()));
};

TEST_F(Pgo, BatchAndOnlineEndAtTheSameCost) {
  const auto [batch, online] = both(write("laps.g2o", laps_graph(4)));
  EXPECT_EQ(batch["status"], "ok");
  EXPECT_EQ(batch["method"], "lm");
  EXPECT_GT(batch["cost"], 0.01);
  EXPECT_NEAR(online["cost"], batch["cost"], 1e-6 * batch["cost"].get<double>());
  EXPECT_NEAR(online["objective"], batch["objective"], 1e-6);
  EXPECT_EQ(batch["inliers"], 24);
  EXPECT_EQ(batch["outliers"], 0);
  EXPECT_FALSE(batch.contains("steps"));
  for (const char* name : {"total_s", "mean_ms", "p50_ms", "p95_ms", "p99_ms", "max_ms"}) {
    EXPECT_GT(online["steps"][name], 0.0) << name;
  }
  EXPECT_GE(online["cost_online"].get<double>(), online["cost"].get<double>() - 1e-9);
}

TEST_F(Pgo, WritesFilesThatReadBack) {
  const std::string graph = write("laps.g2o", laps_graph(3));
  const Ran result = run(graph + " --online -o " + at("out/new"));
  EXPECT_EQ(result.code, 0) << result.text;
  EXPECT_EQ(lines("out/new/steps.csv"), 1 + 24);
  EXPECT_EQ(lines("out/new/loops.csv"), 1 + 16);
  EXPECT_EQ(read("out/new/loops.csv")
                .find("i,j,decision,inlier_probability,residual,redundancy,"
                      "checkable,margin\n0,8,trusted,1"),
            0u);
  for (const char* name : {"graph", "graph_start"}) {
    EXPECT_EQ(read(std::string("out/new/") + name + ".png").substr(1, 3), "PNG") << name;
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "out/new"), {}), 7);
  const PoseGraph written = read_graph(at("out/new/graph.g2o"));
  EXPECT_EQ(written.values.size(), 24u);
  EXPECT_EQ(written.edge_count(), 23u + 16u);
  // Solved again from the estimate, the graph stays where it is.
  EXPECT_EQ(run(at("out/new/graph.g2o") + " --method lm --start file -o " + at("again")).code, 0);
  EXPECT_NEAR(summary("again")["cost"], summary("out/new")["cost"], 1e-9);
  EXPECT_LE(summary("again")["iterations"], 2);
}

TEST_F(Pgo, ComparesWithTheTruth) {
  std::string rows, graph;
  for (int k = 0; k < 6; ++k) {
    rows += std::to_string(5.0 + k) + " 1 0\n";  // in another frame than the graph
    if (k > 0) graph += edge(k - 1, k, SE2(1, 0, 0));
  }
  const std::string file = write("g.g2o", graph);
  ASSERT_EQ(run(file + " --truth " + write("truth.txt", rows) + " -o " + at("out")).code, 0);
  const auto trajectory = summary("out")["truth"]["trajectory"];
  EXPECT_NEAR(trajectory["max_m"], 0.0, 1e-9);
  EXPECT_NEAR(trajectory["aligned"]["rmse_m"], 0.0, 1e-9);
  ASSERT_EQ(run(file + " --truth " + at("out/graph.g2o") + " -o " + at("self")).code, 0);
  EXPECT_NEAR(summary("self")["truth"]["trajectory"]["rotation_rmse_deg"], 0.0, 1e-6);
  expect_failure(file + " --truth " + write("short.txt", "0 0 0\n"), "has 1 poses, the graph 6");
  expect_failure(file + " --truth " + write("bad.txt", "0 0 0\n1 x 2\n"), "bad.txt:2");
}

TEST_F(Pgo, TrajectoriesPairByTheIdOfThePose) {
  std::string graph;
  for (int k = 4; k < 9; ++k) graph += edge(k - 1, k, SE2(1, 0, M_PI_2));
  const std::string file = write("g.g2o", graph);
  ASSERT_EQ(run(file + " --no-pictures -o " + at("out")).code, 0);
  EXPECT_FALSE(fs::exists(at("out/graph.png")));
  EXPECT_FALSE(fs::exists(at("out/trajectory_truth.tum")));
  ASSERT_EQ(run(file + " --truth " + at("out/trajectory.tum") + " -o " + at("self")).code, 0);
  for (const char* name : {"self/trajectory.tum", "self/trajectory_truth.tum"}) {
    std::istringstream rows(read(name));
    std::string heading;
    std::getline(rows, heading);
    for (int k = 3; k < 9; ++k) {
      double stamp = 0, x = 0, rest[6];
      rows >> stamp >> x;
      for (double& value : rest) rows >> value;
      EXPECT_EQ(stamp, k) << name;
      if (k != 4) continue;
      EXPECT_NEAR(x, 1, 1e-9) << name;
    }
  }
}

TEST_F(Pgo, FeedsLandmarksAndPosesThatWait) {
  // Pose 1 is known only through pose 2; landmark 9 is seen twice.
  std::string text = edge(0, 2, SE2(2, 0, 0)) + edge(2, 1, SE2(-1, 0, 0));
  text += edge(2, 3, SE2(1, 0, 0)) + "EDGE_SE2_XY 0 9 1 1 4 0 4\n";
  text += "EDGE_SE2_XY 3 9 -2 1.2 4 0 4\n";
  const auto [batch, online] = both(write("wait.g2o", text));
  EXPECT_EQ(online["landmarks"], 1);
  EXPECT_EQ(online["poses"], 4);
  EXPECT_GT(batch["cost"], 1e-3);
  EXPECT_NEAR(online["cost"], batch["cost"], 1e-6 * batch["cost"].get<double>());
}

TEST_F(Pgo, ExplainsItselfAndFailsClearly) {
  const Ran help = run("--help");
  EXPECT_EQ(help.code, 0);
  EXPECT_EQ(help.text.find("--sparsity"), std::string::npos);
  const std::string good = write("good.g2o", edge(0, 1, SE2()));
  EXPECT_NE(run("").code, 0);
  EXPECT_NE(run(good + " --method newton -o " + at("none")).code, 0);
  expect_failure(at("missing.g2o"), "missing.g2o");
  expect_failure(write("empty.g2o", ""), "empty.g2o");
  expect_failure(write("broken.g2o", edge(0, 1, SE2()) + "EDGE_SE2 1 2 0 0\n"), "broken.g2o:2");
  const std::string parts = write("parts.g2o", edge(0, 1, SE2()) + edge(5, 6, SE2()));
  expect_failure(parts, "connects vertex 5, 6 to vertex 0");
  expect_failure(parts + " --online", "connects vertex 5, 6 to vertex 0");
  expect_failure(good + " --start file", "no VERTEX line for vertex 0, 1; use --start odometry");
  const Ran unwritable = run(good + " -o /proc/none");
  EXPECT_EQ(unwritable.code, 1);
  EXPECT_NE(unwritable.text.find("/proc/none"), std::string::npos) << unwritable.text;
}

TEST_F(Pgo, SolvesPublicGraphs) {
  for (const std::string name : {"CSAIL", "intel"}) {
    const std::string graph = data_dir() + "/pose_graphs/" + name + ".g2o";
    if (!fs::exists(graph)) GTEST_SKIP() << graph << " is not there";
    const auto [batch, online] = both(graph);
    EXPECT_NEAR(online["cost"], batch["cost"], 1e-4 * batch["cost"].get<double>()) << name;
    EXPECT_LT(online["cost_online"], 1.05 * online["cost"].get<double>()) << name;
  }
}

TEST_F(Pgo, RejectsFalseClosuresByDefaultAndByName) {
  // Two false closures: pose 20 was not at pose 3, nor 27 at 9.
  const std::string graph =
      write("false.g2o", laps_graph(4) + edge(20, 3, SE2(0, 0, 2)) + edge(27, 9, SE2(5, -4, 1)));
  std::string labels;
  for (int k = 8; k < 32; ++k) labels += std::to_string(k - 8) + " " + std::to_string(k) + "\n";
  const std::string file = write("labels.txt", labels);
  for (const std::string method : {"", "selection", "portfolio", "alternating", "gnc", "oracle"}) {
    const std::string option = method.empty() ? "" : " --method " + method;
    const Ran result = run(graph + option + " --labels " + file + " -o " + at("out"));
    ASSERT_EQ(result.code, 0) << method << result.text;
    const auto s = summary("out");
    EXPECT_EQ(s["method"], method.empty() ? "selection" : method);
    EXPECT_EQ(s["inliers"], 24) << method;
    EXPECT_EQ(s["outliers"], 2) << method;
    EXPECT_EQ(s["truth"]["loop_precision"], 1.0) << method;
    EXPECT_EQ(s["truth"]["loop_recall"], 1.0) << method;
    EXPECT_EQ(s.contains("members"), method == "portfolio");
    const std::string loops = read("out/loops.csv");
    EXPECT_NE(loops.find("\n0,8,accepted,"), std::string::npos) << loops;
    EXPECT_NE(loops.find("\n20,3,rejected,"), std::string::npos) << loops;
  }
}

TEST_F(Pgo, OffersEveryMethodOfTheTable) {
  const std::string graph = write("g.g2o", laps_graph(3) + edge(20, 3, SE2(0, 0, 2)));
  std::string labels;
  for (int k = 8; k < 24; ++k) labels += std::to_string(k - 8) + " " + std::to_string(k) + "\n";
  const std::string options = graph + " --labels " + write("labels.txt", labels) + " --method ";
  const std::string help = run("--help").text;
  for (const RobustMethod& method : robust_methods()) {
    EXPECT_NE(help.find("\n  " + method.name + " "), std::string::npos) << method.name;
    const Ran result = run(options + method.name + " -o " + at("out"));
    ASSERT_EQ(result.code, 0) << method.name << result.text;
    EXPECT_EQ(summary("out").contains("steps"), method.name == "online");
  }
  expect_failure(graph + " --method oracle", "--labels");
  expect_failure(graph + " --method magic", "known are: odometry, oracle, lm");
}

TEST_F(Pgo, OldNamesOfMethodsWorkWithAWarning) {
  const std::string graph = write("g.g2o", laps_graph(3));
  for (const std::string name : {"selection", "consistency-selection"}) {
    const std::string old = name == "selection" ? "escape" : "consistency-escape";
    const Ran result = run(graph + " --method " + old + " -o " + at("old"));
    ASSERT_EQ(result.code, 0) << result.text;
    EXPECT_NE(result.text.find("warning: --method " + old + " is now called " + name),
              std::string::npos)
        << result.text;
    EXPECT_EQ(summary("old")["method"], name);
    const Ran now = run(graph + " --method " + name + " -o " + at("new"));
    EXPECT_EQ(now.text.find("warning"), std::string::npos) << now.text;
    EXPECT_EQ(summary("new")["objective"], summary("old")["objective"]);
  }
}

TEST_F(Pgo, SettingsOfMethodsComeFromAnIniAndTheCommandLine) {
  const std::string graph = write("g.g2o", laps_graph(3));
  const std::string ini = write("m.ini", "[selection]\nmargin = 1000\n");
  ASSERT_EQ(run(graph + " -c " + ini + " -o " + at("out")).code, 0);
  EXPECT_EQ(summary("out")["inliers"], 0);
  EXPECT_EQ(summary("out")["configuration"]["selection"]["margin"], "1000");
  EXPECT_EQ(summary("out")["inputs"].size(), 2);
  ASSERT_EQ(run(graph + " -c " + ini + " --set selection.margin=1.5 -o " + at("out")).code, 0);
  EXPECT_EQ(summary("out")["inliers"], 16);
  // Online both: the gate of each closure, and the evaluation of all.
  const std::string online = graph + " --online --trusted odometry";
  ASSERT_EQ(run(online + " -o " + at("out")).code, 0);
  EXPECT_EQ(summary("out")["inliers"], 16);
  ASSERT_EQ(run(online + " -c " + ini + " -o " + at("out")).code, 0);
  EXPECT_EQ(summary("out")["inliers"], 0);
  const Ran printed = run("--print-config --set gnc.growth=1.25");
  EXPECT_EQ(printed.code, 0);
  EXPECT_NE(printed.text.find("\ngrowth = 1.25\n"), std::string::npos) << printed.text;
  EXPECT_NE(printed.text.find("[online_selection]"), std::string::npos) << printed.text;
  expect_failure(graph + " --set selection.margni=2", "did you mean 'margin'");
  expect_failure(graph + " --set selection", "SECTION.KEY=VALUE");
  expect_failure(graph + " -c " + at("none.ini"), "none.ini");
}

TEST_F(Pgo, SelectsOnlineAndComparesWithLabels) {
  const std::string graph =
      write("false.g2o", laps_graph(4) + edge(20, 3, SE2(0, 0, 2)) + edge(27, 9, SE2(5, -4, 1)));
  std::string labels;
  for (int k = 8; k < 32; ++k) labels += std::to_string(k - 8) + " " + std::to_string(k) + "\n";
  const std::string options = graph + " --online --labels " + write("labels.txt", labels);
  const Ran selected = run(options + " --trusted odometry -o " + at("selected"));
  ASSERT_EQ(selected.code, 0) << selected.text;
  const auto s = summary("selected");
  EXPECT_EQ(s["inliers"], 24);
  EXPECT_EQ(s["truth"]["loop_precision"], 1.0);
  EXPECT_EQ(s["truth"]["loop_recall"], 1.0);
  const std::string loops = read("selected/loops.csv");
  EXPECT_NE(loops.find("\n20,3,rejected,"), std::string::npos);
  std::istringstream rows(loops.substr(loops.find('\n') + 1));
  for (std::string row; std::getline(rows, row);) {
    std::vector<std::string> cells;
    std::istringstream words(row);
    for (std::string word; std::getline(words, word, ',');) cells.push_back(word);
    ASSERT_EQ(cells.size(), 8u) << row;
    const bool in = cells[2] == "accepted";
    const double redundancy = std::stod(cells[5]), margin = std::stod(cells[7]);
    EXPECT_LT(redundancy, 1.0) << row;
    EXPECT_GT(redundancy, 0.0) << row;
    EXPECT_GT(in ? margin : -margin, 0.0) << row;
  }
  EXPECT_FALSE(s.contains("hypotheses"));
  // Of closures that are all trusted, 24 of 26 are true.
  ASSERT_EQ(run(options + " -o " + at("all")).code, 0);
  EXPECT_NEAR(summary("all")["truth"]["loop_precision"].get<double>(), 24.0 / 26.0, 1e-9);
  expect_failure(options + " --trusted " + write("none.txt", "1 5\n"), "none.txt:1");
}

TEST_F(Pgo, FindsTheFirstHypothesesOfAPublicGraph) {
  const std::string name = data_dir() + "/hybrid_city10000/T1_city10000_04.txt";
  if (!fs::exists(name)) GTEST_SKIP() << name << " is not there";
  std::ifstream in(name);
  std::string text;
  for (std::string line; std::getline(in, line);) {  // the poses up to 770, with 15 choices
    std::istringstream row(line);
    std::string tag;
    int i = 0, one = 0, j = 0;
    row >> tag >> i >> one >> j;
    if (i <= 770 && j <= 770) text += line + "\n";
  }
  const std::string graph = write("city.graph", text);
  for (const std::string seed : {"1", "2"}) {
    ASSERT_EQ(run(graph + " --online --shuffle " + seed + " -o " + at("out")).code, 0);
    const auto s = summary("out");
    EXPECT_EQ(s["hypotheses"], 15);
    EXPECT_EQ(s["first_hypotheses"], 15) << seed;
  }
}

TEST_F(Pgo, TrustsWhatItIsTold) {
  const std::string graph = write("g.g2o", laps_graph(3) + edge(20, 3, SE2(0, 0, 2)));
  std::string pairs = "20 3\n";
  for (int k = 1; k < 24; ++k) pairs += std::to_string(k - 1) + " " + std::to_string(k) + "\n";
  const std::string trusted = write("trusted.txt", pairs);
  ASSERT_EQ(run(graph + " --trusted " + trusted + " -o " + at("out")).code, 0);
  EXPECT_NE(read("out/loops.csv").find("\n20,3,trusted,"), std::string::npos);
  expect_failure(graph + " --trusted " + write("bad.txt", "0 1\n3\n"), "bad.txt:2");
  expect_failure(graph + " --labels " + at("none.txt"), "none.txt");
  // Without odometry between poses 11 and 12, closures have to join the two parts.
  std::string gap = laps_graph(3);
  const std::size_t line = gap.find("EDGE_SE2 11 12 ");
  gap.erase(line, gap.find('\n', line) + 1 - line);
  const Ran result = run(write("gap.g2o", gap) + " -o " + at("gap"));
  EXPECT_EQ(result.code, 0) << result.text;
  EXPECT_NE(summary("gap")["health"].dump().find("joined by closures that agree"),
            std::string::npos);
  EXPECT_EQ(summary("gap")["outliers"], 0);
}

TEST_F(Pgo, OdometryInQuestionShiftsNoDecision) {
  // The file names all odometry but that from 5 to 6; the closure that comes last is false.
  const std::string graph = write("g.g2o", laps_graph(4) + edge(27, 9, SE2(5, -4, 1)));
  std::string pairs;
  for (int k = 1; k < 32; ++k) {
    if (k != 6) pairs += std::to_string(k - 1) + " " + std::to_string(k) + "\n";
  }
  const std::string trusted = " --trusted " + write("trusted.txt", pairs);
  const Ran ran = run(graph + trusted + " --no-pictures -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  EXPECT_NE(read("out/loops.csv").find("\n27,9,rejected,"), std::string::npos);
  EXPECT_NE(read("out/loops.csv").find("\n5,6,"), std::string::npos);
  const auto result = summary("out");
  for (const auto& noise : result["noise"]) {
    if (noise["measured"].is_null()) continue;
    EXPECT_LT(noise["measured"].get<double>(), 2.0) << noise["kind"];
  }
}

TEST_F(Pgo, StartsFromChordalRotations) {
  const std::string graph = write("g.g2o", laps_graph(4));
  ASSERT_EQ(run(graph + " --method lm -o " + at("a")).code, 0);
  ASSERT_EQ(run(graph + " --method lm --start chordal -o " + at("b")).code, 0);
  EXPECT_NEAR(summary("a")["cost"], summary("b")["cost"], 1e-9);
}

}  // namespace
}  // namespace hybrid
