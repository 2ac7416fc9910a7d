// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <set>

#include "libhybrid/io/folders.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/bridge/sha256.h"
#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class OutputFolders : public ReplayTest {
 protected:
  /// Names of what is in folder/out.
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const FolderEntry& entry : entries_of(folder / "out")) found.insert(entry.name);
    return found;
  }
  nlohmann::json summary() const { return nlohmann::json::parse(read("out/summary.json")); }
  /// A pose graph of a square with a closure.
  std::string graph() const {
    return write(
        "square.g2o",
        "EDGE_SE2 0 1 1 0 1.57 100 0 0 100 0 100\nEDGE_SE2 1 2 1 0 1.57 100 0 0 100 0 100\n"
        "EDGE_SE2 2 3 1 0 1.57 100 0 0 100 0 100\nEDGE_SE2 3 0 1 0 1.57 100 0 0 100 0 100\n");
  }
  /// Two clouds that are the same corner of three planes.
  std::string clouds() const {
    std::string text;
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        const std::string a = std::to_string(0.1 * i), b = std::to_string(0.1 * j);
        text += a + " " + b + " 0\n" + a + " 0 " + b + "\n0 " + a + " " + b + "\n";
      }
    }
    write("a.xyz", text);
    write("b.xyz", text);
    return at("a.xyz") + " " + at("b.xyz");
  }
};

const std::string kSlip = "-c " + config("slip_demo.ini") + " --no-pictures";
const std::string kClassed = "-c " + config("classed_demo.ini") + " --no-pictures";

TEST_F(OutputFolders, EveryProgramTellsItsVersion) {
  for (const char* name :
       {"hybrid-experiment", "hybrid-import", "hybrid-objects", "hybrid-pgo", "hybrid-register",
        "hybrid-replay", "hybrid-simulate", "hybrid-switching"}) {
    const Ran ran = run_app(std::string(name) + " --version");
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_EQ(ran.text.rfind(std::string(name) + " 0.", 0), 0U) << ran.text;
  }
}

TEST_F(OutputFolders, TheSummaryNamesVersionCommandConfigurationAndInputs) {
  const auto summary = summary_of(kClassed + " --set solver.mode=batch");
  const std::string version = run_app("hybrid-replay --version").text;
  EXPECT_EQ("hybrid-replay " + summary["version"].get<std::string>() + "\n", version);
  EXPECT_EQ(summary["command"].back(), at("out"));
  EXPECT_EQ(summary["configuration"]["solver"]["mode"], "batch");
  const auto& inputs = summary["inputs"];
  ASSERT_EQ(inputs.size(), 4U);  // log, INI, true path, true map
  for (const auto& input : inputs) {
    EXPECT_EQ(input["sha256"], sha256_of_file(input["path"].get<std::string>()));
  }
}

TEST_F(OutputFolders, OtherProgramsNameTheirInputsToo) {
  const auto inputs = [&](const std::string& command) {
    const Ran ran = run_app(command + " -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    std::vector<std::string> paths;
    const nlohmann::json inputs = summary()["inputs"];
    for (const auto& input : inputs) paths.push_back(input["path"]);
    return paths;
  };
  const std::string file = graph();
  EXPECT_EQ(inputs("hybrid-pgo " + file), std::vector<std::string>{file});
  clouds();
  EXPECT_EQ(inputs("hybrid-register " + clouds()),
            (std::vector<std::string>{at("a.xyz"), at("b.xyz")}));
  EXPECT_EQ(names(), (std::set<std::string>{"overlay.png", "summary.json", "transform.txt"}));
}

TEST_F(OutputFolders, ATableThatEndsInsideALineIsToldOf) {
  const std::string whole = read(fs::path(graph()).filename());
  const std::string warning = "its last line has no end; is the file cut off?";
  for (const bool cut : {false, true}) {
    const std::string file = write("cut.g2o", cut ? whole.substr(0, whole.size() - 1) : whole);
    const Ran ran = run_app("hybrid-pgo " + file + " -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_EQ(ran.text.find(file + ": " + warning) != std::string::npos, cut) << ran.text;
    EXPECT_EQ(summary()["inputs"][0].value("warning", ""), cut ? warning : "");
  }
  // The last byte of a compressed log is no end of a line either.
  summary_of(kClassed);
  for (const auto& text : summary().value("warnings", nlohmann::json::array())) {
    EXPECT_EQ(text.get<std::string>().find(warning), std::string::npos) << text;
  }
}

// Hashing it takes minutes of processor time, refusing it none.
TEST_F(OutputFolders, AFileThatIsTooLargeIsRefusedBeforeItIsHashed) {
  const std::string huge = write("huge", "");
  fs::resize_file(huge, std::uintmax_t{100} << 30);  // without blocks on the disk
  write("e.ini", "[experiment]\ngraphs = a\nmethods = gnc\n[a]\nfile = huge\n");
  for (const std::string& command :
       {"hybrid-pgo " + graph() + " --labels " + huge, "hybrid-pgo " + huge,
        "hybrid-replay " + kSlip + " --set log.truth_modes=" + huge,
        "hybrid-replay " + kSlip + " --rawlog " + huge,
        "hybrid-experiment -c " + at("e.ini") + " --data-dir " + folder.string()}) {
    const Ran ran = run_app(command + " -o " + at("out"), "ulimit -t 20; ");
    EXPECT_EQ(ran.code, 1) << command << "\n" << ran.text;
    EXPECT_NE(ran.text.find(huge + ": "), std::string::npos) << ran.text;
  }
}

TEST_F(OutputFolders, HoldOneResultAndFilesOfOthers) {
  summary_of(kSlip);
  EXPECT_EQ(names().count("modes.csv"), 1U);
  write("out/notes.txt", "mine");
  summary_of(kClassed);
  EXPECT_EQ(names(),
            (std::set<std::string>{"trajectory.tum", "trajectory_dead_reckoning.tum",
                                   "trajectory_truth.tum", "landmarks.csv", "landmarks.json",
                                   "graph.g2o", "steps.csv", "summary.json", "notes.txt"}));
}

TEST_F(OutputFolders, ASecondProgramIsRefusedByName) {
  OutputDirectory held(folder / "out");
  held.write("a", "1");
  for (const std::string& command :
       {"hybrid-replay " + kClassed, "hybrid-pgo " + graph(), "hybrid-register " + clouds()}) {
    const Ran ran = run_app(command + " -o " + at("out"));
    EXPECT_EQ(ran.code, 1) << command;
    EXPECT_NE(ran.text.find(at("out") + "': "), std::string::npos) << ran.text;
    EXPECT_NE(ran.text.find("(process " + std::to_string(::getpid()) + ") is writing it"),
              std::string::npos)
        << ran.text;
  }
  held.publish({{"status", "ok"}});
  EXPECT_EQ(names(), (std::set<std::string>{"a", "summary.json"}));
}

TEST_F(OutputFolders, AFailureLeavesNoFolderBehind) {
  const Ran ran =
      run_replay(kClassed + " --rawlog " + write("not.rawlog", "no log") + " -o " + at("new/out"));
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_FALSE(fs::exists(at("new")));
}

/// Limits files of the program to so many blocks of 512 bytes.
std::string limit(int blocks) {
  return "ulimit -f " + std::to_string(blocks) + "; ";
}

TEST_F(OutputFolders, AFileThatCannotBeWrittenIsNamedAndTheOldResultStays) {
  summary_of(kSlip);
  const std::string before = read("out/summary.json");
  const std::set<std::string> old = names();
  const Ran ran = run_app("hybrid-replay " + kClassed + " -o " + at("out"), limit(10));
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_NE(ran.text.find("cannot write '" + at("out/")), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find("File too large"), std::string::npos) << ran.text;
  EXPECT_EQ(read("out/summary.json"), before);
  EXPECT_EQ(names(), old);
}

// Sanitizers reserve address space of their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Where memory ends depends on the machine, so that limits are tried down to the one at which no
// program starts.
TEST_F(OutputFolders, LackOfMemoryForPicturesIsSaidAsSuch) {
  const std::string replay = "hybrid-replay -c " + config("classed_demo.ini") + " -o " + at("out");
  std::size_t lacking = 0;
  for (int megabytes = 350; megabytes > 0; megabytes -= 10) {
    const std::string limit = "ulimit -v " + std::to_string(megabytes * 1000) + "; ";
    if (run_app("hybrid-replay --version", limit).code != 0) break;
    const Ran ran = run_app(replay, limit);
    EXPECT_EQ(ran.text.find("OpenCV("), std::string::npos) << ran.text;
    EXPECT_LE(ran.code, 1) << ran.text;
    lacking += ran.text.find("hybrid-replay: out of memory") != std::string::npos ? 1 : 0;
  }
  if (lacking == 0) GTEST_SKIP() << "no limit leaves memory for all but the pictures";
}
#endif

TEST_F(OutputFolders, ALogThatCannotBeWrittenIsOneMessageWithItsName) {
  const std::string log = at("log.rawlog");
  const std::string simulate =
      "hybrid-simulate -c " + config("simulate_classed_demo.ini") + " -o " + log;
  write("odometry.csv", "time,x,y,yaw\n0,0,0,0\n1,1,0,0\n2,2,0,0\n");
  std::string rows = "time,range,yaw,class,score,id\n";
  for (int i = 0; i < 3000; ++i) {
    rows += "1," + std::to_string(3 + 0.001 * ((i * 7919) % 3001)) + ",0,tree,0.9," +
            std::to_string(i) + "\n";
  }
  const std::string import = "hybrid-import csv --odometry " + at("odometry.csv") +
                             " --detections " + write("detections.csv", rows) + " -o " + log;
  for (const std::string& command : {simulate, import}) {
    const Ran ran = run_app(command, limit(8));
    EXPECT_EQ(ran.code, 1) << ran.text;
    EXPECT_NE(ran.text.find("cannot write '" + at("log")), std::string::npos) << ran.text;
    EXPECT_NE(ran.text.find("': File too large\n"), std::string::npos) << ran.text;
    EXPECT_EQ(ran.text.find('\n'), ran.text.size() - 1) << ran.text;
    for (const FolderEntry& entry : entries_of(folder)) {
      EXPECT_EQ(entry.name.find("log"), std::string::npos) << entry.name;
    }
  }
  fs::create_directories(log);
  for (const std::string& command : {simulate, import}) {
    EXPECT_NE(run_app(command).text.find("log.rawlog': is a folder"), std::string::npos);
  }
}

TEST_F(OutputFolders, ANewLogTakesTheTruthOfTheOldOneAway) {
  const std::string log = " -o " + at("log.rawlog");
  ASSERT_EQ(run_app("hybrid-simulate -c " + config("simulate_slip_demo.ini") + log).code, 0);
  EXPECT_TRUE(fs::exists(at("log_ground_truth_modes.txt")));
  ASSERT_EQ(run_app("hybrid-simulate -c " + config("simulate_classed_demo.ini") + log).code, 0);
  EXPECT_FALSE(fs::exists(at("log_ground_truth_modes.txt")));
  EXPECT_EQ(entries_of(folder).size(), 3U);
}

TEST_F(OutputFolders, ClosedOrFullStandardFilesLoseNothing) {
  const auto reference = [&] {
    std::string text;
    for (const char* name : {"trajectory.tum", "landmarks.csv", "graph.g2o"}) {
      text += read(std::string("out/") + name);
    }
    return text;
  };
  summary_of(kClassed);
  const std::string expected = reference();
  for (const char* shut : {">&-", "2>&-", "<&- >&- 2>&-", ">/dev/full", ">/dev/full 2>/dev/full"}) {
    fs::remove_all(at("out"));
    const Ran ran = run_shell(HYBRID_BINARY_DIR "/bin/hybrid-replay " + kClassed + " -o " +
                              at("out") + " " + shut);
    EXPECT_EQ(ran.code, 0) << shut << ran.text;
    EXPECT_EQ(reference(), expected) << shut;
    EXPECT_EQ(summary()["status"], "ok") << shut;
  }
}

TEST_F(OutputFolders, AReadOnlyFolderIsLeftAlone) {
  summary_of(kSlip);
  const std::string before = read("out/summary.json");
  fs::permissions(folder / "out", fs::perms::owner_read | fs::perms::owner_exec);
  // Also root may not write then.
  const std::string weak = "setpriv --bounding-set=-dac_override --inh-caps=-dac_override ";
  const bool root = ::geteuid() == 0;
  if (root && run_app("hybrid-replay --version", weak).code != 0) GTEST_SKIP() << "no setpriv";
  const Ran ran =
      run_app("hybrid-replay " + kClassed + " -o " + at("out"), root ? weak : std::string());
  fs::permissions(folder / "out", fs::perms::owner_all);
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_NE(ran.text.find("Permission denied"), std::string::npos) << ran.text;
  EXPECT_EQ(read("out/summary.json"), before);
}

TEST_F(OutputFolders, AFullDiskLeavesTheOldResult) {
  const std::string disk = at("disk");
  fs::create_directories(disk);
  const std::string replay = HYBRID_BINARY_DIR "/bin/hybrid-replay ";
  const std::string result = " -o " + disk + "/out";
  const Ran ran =
      run_shell("unshare -m sh -c '(mount -t tmpfs -o size=450k none " + disk + " || exit 77; " +
                replay + kClassed + result + " || exit 78; cp -r " + disk + "/out " + at("old") +
                "; " + replay + kSlip + result + "; code=$?; cp -r " + disk + "/out " + at("out") +
                "; ls -A " + disk + "; exit $code)' 2>&1");
  if (ran.code != 1) GTEST_SKIP() << "no file system of its own: " << ran.text;
  EXPECT_NE(ran.text.find("No space left on device"), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find(disk + "/out"), std::string::npos) << ran.text;
  EXPECT_EQ(ran.text.substr(ran.text.rfind('\n', ran.text.size() - 2) + 1), "out\n") << ran.text;
  EXPECT_EQ(read("out/summary.json"), read("old/summary.json"));
}

}  // namespace
}  // namespace hybrid
