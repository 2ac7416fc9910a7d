// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/stat.h>

#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <vector>

#include "tests/apps/replay_runner.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

const std::string kDemoLog = "/usr/share/mrpt/datasets/kf-slam_demo.rawlog";
const std::string kClassedLog = HYBRID_SOURCE_DIR "/rawlogs/classed_demo.rawlog";

std::string with_log(const std::string& path) {
  return "-c " + config("kf_slam_demo.ini") + " --rawlog " + path +
         " --truth-path /usr/share/mrpt/datasets/kf-slam_demo_ground_truth_robot_path.txt";
}

TEST_F(ReplayTest, IniNonsenseNamesSectionAndKey) {
  const std::string log = "[log]\nrawlog = " + kDemoLog + "\n";
  const auto fails = [&](const std::string& text, const std::string& part) {
    expect_failure("-c " + write("a.ini", log + text), part);
  };
  fails("[solver]\nmax_iteration = 3\n", "max_iteration");
  fails("[solver]\nmax_iteration = 3\n", "a.ini:4");
  fails("[solvers]\nthreads = 3\n", "[solvers]");
  fails("[solver]\nthreads = many\n", "threads");
  fails("[solver]\nmode = magic\n", "mode");
  fails("[sensor]\nsigma_range = -1\n", "sigma_range");
  fails("[sensor]\nmax_range = nan\n", "max_range");
  fails("[odometry]\nsigmas = 0.1 0.1\n", "[odometry] sigmas has 2 numbers");
  fails("[odometry]\nsigmas = 0.1 0.1 0\n", "sigmas");
  fails("[plugins]\nclasses = Nothing\n", "registered are: BeaconRanges");
  fails("[plugins\n", "lacks its ']'");
  fails(
      "[plugins]\nclasses = ClassedBearingRangeKnownIds\n[ClassedBearingRangeKnownIds]\n"
      "class_names = a b\nconfusion = 1 0 1\n",
      "confusion");
  const std::string valid = "-c " + write("valid.ini", log);
  expect_failure(valid + " --set solver.mode=magic", "mode");
  expect_failure(valid + " --set solver.moed=batch", "moed");
  expect_failure(valid + " --set solver", "SECTION.KEY=VALUE");
  expect_failure("-c " + at("none.ini"), "none.ini");
  expect_failure("-c " + write("empty.ini", "[map]\ndimension = 2\n"), "rawlog");
}

TEST_F(ReplayTest, OldNamesOfKeysWorkWithAWarning) {
  const std::string both = "[log]\nrawlog = " + kDemoLog + "\nperiod = 1\n[reader]\nperiod = 1\n";
  expect_failure("-c " + write("both.ini", both), "[reader] period is given twice");
  const auto replay_of = [&](const std::string& text) {
    return summary_of("-c " + write("a.ini", "[log]\nrawlog = " + kDemoLog + "\n" + text));
  };
  const auto old = replay_of("max_speed = 50\n[keyframes]\nmin_distance = 0.5\ngather = yes\n");
  const auto now =
      replay_of("[reader]\nmax_speed = 50\n[keyframes]\nmin_distance = 0.5\ntracklets = yes\n");
  EXPECT_EQ(old["objective"], now["objective"]);
  EXPECT_EQ(old["configuration"], now["configuration"]);
  EXPECT_EQ(old["warnings"].size(), now["warnings"].size() + 2);
  const std::string text = old["warnings"].dump();
  EXPECT_NE(text.find("a.ini:3:1: [log] max_speed is now [reader] max_speed"), std::string::npos);
  EXPECT_NE(text.find("[keyframes] gather is now [keyframes] tracklets"), std::string::npos);
  const Ran ran =
      run_replay("-c " + at("a.ini") + " --set keyframes.gather=yes --no-pictures -o " + at("out"));
  EXPECT_NE(ran.text.find("warning: command line: [keyframes] gather is now"), std::string::npos)
      << ran.text;
}

TEST_F(ReplayTest, OldNamesOfKeysOfPlugins) {
  const std::vector<std::pair<std::string, std::string>> renamed = {
      {"BearingRangeAssociation.caution=2", "\ninformation_penalty = 2\n"},
      {"BeaconRanges.circle_places=11", "\ncircle_hypotheses = 11\n"},
      {"BeaconRanges.sphere_places=12", "\nsphere_hypotheses = 12\n"}};
  for (const auto& [old, now] : renamed) {
    const Ran ran = run_replay("--print-config --set " + old);
    EXPECT_EQ(ran.code, 0) << ran.text;
    EXPECT_NE(ran.text.find(now), std::string::npos) << now;
  }
}

TEST_F(ReplayTest, UnusableLogsFail) {
  expect_failure(with_log(at("none.rawlog")), "none.rawlog");
  expect_failure(with_log(write("empty.rawlog", "")), "empty.rawlog");
  expect_failure(with_log(write("text.rawlog", "this is not a rawlog\n")), "text.rawlog");
  expect_failure(with_log(folder.string()), folder.string());
  expect_failure(with_log(write("graph.rawlog", "VERTEX_SE2 0 0 0 0\n")), "use hybrid-pgo");
  ASSERT_EQ(mkfifo(at("pipe.rawlog").c_str(), 0600), 0);
  expect_failure(with_log(at("pipe.rawlog")), "pipe.rawlog");
}

TEST_F(ReplayTest, MissingOrMalformedTruthFails) {
  const std::string demo = "-c " + config("kf_slam_demo.ini");
  expect_failure(demo + " --truth-map " + at("none.txt"), "none.txt");
  expect_failure(demo + " --truth-path " + write("bad.txt", "1 2 x\n"), "bad.txt:1");
  expect_failure(demo + " --truth-path " + write("short.txt", "0 0 0 0 0 0\n"), "short.txt");
}

TEST_F(ReplayTest, ANumberedTruthBeginsAtTheStepThatIsGivenAndMayEndEarly) {
  const auto rmse_at = [&](const std::string& step) {
    const auto summary =
        summary_of("-c " + config("uwb_demo.ini") + " --set log.truth_step=" + step);
    return summary["truth"]["trajectory"]["rmse_m"].get<double>();
  };
  const double right = rmse_at("1");
  EXPECT_LT(right, 0.3);
  EXPECT_GT(rmse_at("0"), 2 * right);
  const auto truth = summary_of("-c " + config("uwb_demo.ini"))["truth"];
  EXPECT_GT(truth["nees_pose"], 0.3);
  EXPECT_LT(truth["nees_pose"], 3);
  EXPECT_LT(truth["trajectory"]["aligned"]["rmse_m"].get<double>(),
            0.5 * truth["dead_reckoning"]["aligned"]["rmse_m"].get<double>());
}

TEST_F(ReplayTest, ATruthOfAnotherLogWhoseTimesFitIsTold) {
  const std::string told = "is it the truth of another log?";
  const auto warnings = [&](const std::string& arguments) {
    return summary_of(arguments)["warnings"].dump();
  };
  const std::string other = "/usr/share/mrpt/datasets/kf-slam_6D_demo_ground_truth_robot_path.txt";
  EXPECT_NE(warnings(kDemoLog + " --truth-path " + other).find(told), std::string::npos);
  for (const char* own : {"kf_slam_demo.ini", "kf_slam_6d_demo.ini", "classed_demo.ini",
                          "classed_demo_3d.ini", "slip_demo.ini", "ro_slam_demo.ini"}) {
    const std::string text = warnings("-c " + config(own));
    EXPECT_EQ(text.find(told), std::string::npos) << own << text;
  }
}

TEST_F(ReplayTest, ATruthOfFewKeyframesIsTold) {
  summary_of(kClassedLog);
  std::istringstream path(read_file(folder / "out" / "trajectory.tum"));
  std::string line, text;
  std::vector<std::string> rows;
  while (std::getline(path, line)) {
    if (line.empty() || line.front() == '#') continue;
    rows.push_back(text += line + "\n");  // with those before
  }
  ASSERT_GT(rows.size(), 100U);
  const auto told = [&](std::size_t count) {
    const Ran ran = run_replay(kClassedLog + " --truth-path " + write("few.tum", rows[count - 1]) +
                               " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return ran.text;
  };
  const std::string one = told(1);
  EXPECT_EQ(one.find("path rmse"), std::string::npos) << one;
  EXPECT_NE(one.find("few.tum: 1 of "), std::string::npos) << one;
  EXPECT_NE(one.find(" keyframes has a true pose -> "), std::string::npos) << one;
  const std::string few = told(5);
  EXPECT_NE(few.find("few.tum: 5 of "), std::string::npos) << few;
  EXPECT_NE(few.find("m (5 of "), std::string::npos) << few;
  const std::string part = told(rows.size() / 2);
  EXPECT_EQ(part.find("few.tum: "), std::string::npos) << part;
  EXPECT_NE(part.find("keyframes have a true pose) -> "), std::string::npos) << part;
  EXPECT_EQ(told(rows.size()).find("a true pose"), std::string::npos);
}

TEST_F(ReplayTest, TruncatedLogGivesAPartialMap) {
  const std::string whole = read_file(kDemoLog);
  const std::string cut = write("cut.rawlog", whole.substr(0, whole.size() / 2));
  const auto summary = summary_of(with_log(cut), 2);
  EXPECT_EQ(summary["status"], "partial");
  EXPECT_NE(summary["message"].get<std::string>().find("cut.rawlog"), std::string::npos);
  EXPECT_GT(summary["keyframes"], 50);
  EXPECT_LT(summary["keyframes"], 250);
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"], 0.05);
}

TEST_F(ReplayTest, FlippedBitsAreNeverTakenForAGoodLog) {
  const std::string whole = read_file(kDemoLog);
  for (const double place : {0.1, 0.35, 0.6, 0.9}) {
    std::string damaged = whole;
    damaged[static_cast<std::size_t>(place * static_cast<double>(whole.size()))] ^= 0x10;
    const Ran ran =
        run_replay(with_log(write("flipped.rawlog", damaged)) + " --no-pictures -o " + at("out"));
    EXPECT_TRUE(ran.code == 1 || ran.code == 2) << place << ": " << ran.code << " " << ran.text;
    EXPECT_NE(ran.text.find("flipped.rawlog"), std::string::npos) << ran.text;
  }
}

/// Exit code, and the message of the summary if there is one.
std::pair<int, std::string> result_of(const std::string& arguments, const std::string& out) {
  const Ran ran = run_replay(arguments + " --no-pictures -o " + out);
  const std::string text = read_file(out + "/summary.json");
  if (ran.code != 2) return {ran.code, ran.text};
  return {ran.code, nlohmann::json::parse(text)["message"].get<std::string>()};
}

TEST_F(ReplayTest, ABitFlippedNearTheEndLosesOnlyTheEnd) {
  std::string damaged = read_file(kDemoLog);
  damaged[damaged.size() - 600] ^= 0x10;
  const auto summary = summary_of(with_log(write("flipped.rawlog", damaged)), 2);
  EXPECT_EQ(summary["status"], "partial");
  EXPECT_GE(summary["keyframes"], 240);
}

TEST_F(ReplayTest, ZstandardLogsAreReplayed) {
  const auto expected = summary_of("-c " + config("classed_demo.ini"));
  fs::remove_all(at("out"));
  const std::string log = write("a.rawlog", zstd(decode(read_file(kClassedLog)).bytes));
  const auto summary = summary_of("-c " + config("classed_demo.ini") + " --rawlog " + log);
  EXPECT_EQ(summary["objective"], expected["objective"]);
}

TEST_F(ReplayTest, DamageBehindARightChecksumNeverEndsTheProgram) {
  const std::string plain = decode(read_file(kClassedLog)).bytes;
  std::mt19937 random(7);
  int partial = 0;
  for (int trial = 0; trial < 25; ++trial) {
    std::string bytes = plain;
    const std::size_t place = random() % (bytes.size() - 8);
    if (trial % 3 == 0) bytes.erase(place, 1 + random() % 200);
    if (trial % 3 == 1) bytes.replace(place, 4, std::string("\xff\xff\xff\x7f", 4));
    if (trial % 3 == 2) bytes[place] = static_cast<char>(random());
    const auto [code, message] = result_of(
        "-c " + config("classed_demo.ini") + " --rawlog " + write("damaged.rawlog", gzip(bytes)),
        at("out" + std::to_string(trial)));
    EXPECT_TRUE(code == 0 || code == 1 || code == 2) << trial << ": " << code << " " << message;
    partial += code == 2 ? 1 : 0;
  }
  EXPECT_GT(partial, 8);
}

TEST_F(ReplayTest, MotionOfAnUnknownKindBehindARightChecksum) {
  std::string bytes = decode(read_file(kClassedLog)).bytes;
  const std::string name = "CActionRobotMovement2D";
  const std::size_t at = bytes.find(name, bytes.size() / 2) + name.size() + 1;
  bytes[at] = 44;
  const auto summary = summary_of(
      "-c " + config("classed_demo.ini") + " --rawlog " + write("kind.rawlog", gzip(bytes)), 2);
  EXPECT_EQ(summary["status"], "partial");
  EXPECT_GT(summary["keyframes"], 80);
}

TEST_F(ReplayTest, OneByteThatClaimsPitchDoesNotDecideTheMap) {
  std::string bytes = decode(read_file(kClassedLog)).bytes;
  // The flag stands before the number of classes, which is that of the names.
  const std::string count("\x04\0\0\0\x04\0\0\0tree", 12);
  const std::size_t flag = bytes.find(count) - 1;
  ASSERT_EQ(bytes[flag], 0);
  bytes[flag] = 1;
  const auto summary =
      summary_of("-c " + config("classed_demo.ini") + " --set 'odometry.sigmas=0.1 0.1 0.05'" +
                 " --rawlog " + write("pitch.rawlog", gzip(bytes)));
  EXPECT_GT(summary["dropped"]["detection dropped: pitch measured, but the map is in the plane"],
            0);
}

TEST_F(ReplayTest, UnwritableOutputFails) {
  const std::string file = write("file", "not a folder");
  const Ran ran = run_replay("-c " + config("kf_slam_demo.ini") + " -o " + file + "/out");
  EXPECT_EQ(ran.code, 1) << ran.text;
  EXPECT_NE(ran.text.find(file), std::string::npos) << ran.text;
}

/// A log of 20 frames, a metre apart, that see two landmarks, one of them once as NaN and once far.
std::string log_with_bad_measurements(const std::string& path, float std_pitch) {
  mrpt::io::CFileGZOutputStream file(path);
  auto archive = mrpt::serialization::archiveFrom(file);
  for (int i = 0; i < 20; ++i) {
    if (i > 0) {
      mrpt::obs::CActionCollection actions;
      mrpt::obs::CActionRobotMovement2D motion;
      mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
      motion.computeFromOdometry(mrpt::poses::CPose2D(1, 0, 0), options);
      actions.insert(motion);
      archive << actions;
    }
    mrpt::obs::CSensoryFrame frame;
    auto seen = mrpt::obs::CObservationBearingRange::Create();
    seen->sensor_std_range = seen->sensor_std_yaw = 0.01F;
    seen->sensor_std_pitch = std_pitch;
    seen->fieldOfView_yaw = static_cast<float>(2.0 * M_PI);  // it passes the landmarks
    for (int id = 0; id < 2; ++id) {
      const double dx = 10 * id - i, dy = 4;
      mrpt::obs::CObservationBearingRange::TMeasurement m;
      m.range = static_cast<float>(std::hypot(dx, dy));
      m.yaw = static_cast<float>(std::atan2(dy, dx));
      m.pitch = 0;
      m.landmarkID = id;
      if (id == 1 && i == 5) m.range = std::numeric_limits<float>::quiet_NaN();
      if (id == 1 && i == 6) m.range = 1e6F;
      if (id == 1 && i == 7) m.landmarkID = mrpt::obs::INVALID_LANDMARK_ID;
      seen->sensedData.push_back(m);
    }
    frame.insert(seen);
    archive << frame;
  }
  return path;
}

class BadMeasurements : public ReplayTest, public ::testing::WithParamInterface<float> {};

TEST_P(BadMeasurements, AreDroppedAndCounted) {
  const std::string log = log_with_bad_measurements(at("bad.rawlog"), GetParam());
  const std::string ini = write("a.ini", "[log]\nrawlog = " + log + "\n");
  const auto summary = summary_of("-c " + ini);
  EXPECT_EQ(summary["dropped"]["detection dropped: range not finite"], 1);
  EXPECT_EQ(summary["dropped"]["detection dropped: range above limit"], 1);
  EXPECT_EQ(summary["dropped"]["detection dropped: no landmark id"], 1);
  const auto map = nlohmann::json::parse(read_file(folder / "out" / "landmarks.json"));
  ASSERT_EQ(map["landmarks"].size(), 2U);
  EXPECT_EQ(map["landmarks"][0]["sightings"], 20);
  EXPECT_EQ(map["landmarks"][1]["sightings"], 17);
  EXPECT_NEAR(map["landmarks"][1]["position"][0], 10.0, 0.01);
  EXPECT_NEAR(map["landmarks"][1]["position"][1], 4.0, 0.01);
}

// Planar odometry with a planar sensor, and with one that measures pitch.
INSTANTIATE_TEST_SUITE_P(Pitch, BadMeasurements, ::testing::Values(0.0F, 0.01F));

TEST_F(ReplayTest, LogWithoutDetectionsGivesAPathAndIsCalledEmpty) {
  const std::string ini = write(
      "a.ini", "[log]\nrawlog = " + kDemoLog + "\n[BearingRangeKnownIds]\nsensors = nobody\n");
  const auto summary = summary_of("-c " + ini, 2);
  EXPECT_EQ(summary["status"], "empty");
  EXPECT_NE(summary["message"].get<std::string>().find("no landmark"), std::string::npos);
  EXPECT_EQ(summary["landmarks"], 0);
  EXPECT_EQ(summary["keyframes"], 250);
}

}  // namespace
}  // namespace hybrid
