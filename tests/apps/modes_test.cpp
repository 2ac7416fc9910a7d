// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <sstream>
#include <string>

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

class MotionModes : public ReplayTest {
 protected:
  /// The INI of the demonstration with its paths made absolute.
  std::string demo() const {
    std::string ini = read_file(config("slip_demo.ini"));
    const std::string to = std::string("= ") + HYBRID_SOURCE_DIR + "/rawlogs/";
    for (std::size_t p; (p = ini.find("= ../rawlogs/")) != std::string::npos;) {
      ini.replace(p, 13, to);
    }
    return ini;
  }
  std::string without_modes() const {
    std::string ini = demo();
    const std::string line = "modes = normal slip";
    return ini.replace(ini.find(line), line.size(), "");
  }
  /// With noise as stated: what is measured explains slip as well.
  static std::string solver(const std::string& mode) {
    return "\n[sensor]\nnoise = stated\n[solver]\nmode = " + mode + "\n";
  }
};

TEST_F(MotionModes, SlipIsFoundOnlineInAWindowAndInBatch) {
  for (const char* mode :
       {"incremental", "bounded\ncomplete = 60\nsightings = 8", "fixed_lag", "batch"}) {
    const auto with = summary_of("-c " + write("with.ini", demo() + solver(mode)));
    const auto without = summary_of("-c " + write("without.ini", without_modes() + solver(mode)));
    const auto& modes = with["truth"]["modes"];
    EXPECT_GE(modes["precision"].get<double>(), 0.65) << mode;
    EXPECT_GE(modes["recall"].get<double>(), 0.8) << mode;
    EXPECT_EQ(modes["motions"].get<int>(), 250);
    EXPECT_LT(with["truth"]["trajectory"]["rmse_m"].get<double>(),
              0.8 * without["truth"]["trajectory"]["rmse_m"].get<double>())
        << mode;
    EXPECT_LT(with["objective"].get<double>(), without["objective"].get<double>()) << mode;
  }
}

TEST_F(MotionModes, WritesModesAndDrawsThem) {
  const Ran ran = run_replay("-c " + write("with.ini", demo()) + " -o " + at("out"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  std::istringstream rows(read_file(folder / "out" / "modes.csv"));
  std::string row;
  std::getline(rows, row);
  EXPECT_EQ(row, "keyframe,time,mode,p_normal,p_slip");
  int count = 0, slips = 0;
  while (std::getline(rows, row)) {
    ++count;
    const bool slip = row.find(",slip,") != std::string::npos;
    slips += slip;
    const double p = std::stod(row.substr(row.rfind(',') + 1));
    EXPECT_GE(p, 0.0);
    EXPECT_LE(p, 1.0);
    EXPECT_TRUE(!slip || p > 0.01) << row;
  }
  EXPECT_EQ(count, 250);
  const auto summary = nlohmann::json::parse(read_file(folder / "out" / "summary.json"));
  EXPECT_EQ(summary["modes"]["slip"].get<int>(), slips);
  EXPECT_GT(std::filesystem::file_size(folder / "out" / "map.png"), 10000U);
}

TEST_F(MotionModes, BadInputIsNamed) {
  const std::string line = "modes = normal slip";
  const auto fails = [&](const std::string& instead, const std::string& part) {
    std::string ini = demo();
    ini.replace(ini.find(line), line.size(), instead);
    expect_failure("-c " + write("bad.ini", ini), part);
  };
  fails(line + "\ntransition = 0.9 0.1 0.3 0.6",
        "row 2 of the transition matrix must sum to 1, its sum is 0.9");
  fails(line + "\ntransition = 0.9 0.1", "needs 4 numbers for 2 modes");
  fails("modes = normal", "names one mode");
  fails(line + "\nshare = 1", "has 1 numbers for 2 modes");
  fails(line + "\nshare_sigma = -1 0", "share_sigma");
  std::string ini = demo();
  const std::string truth = HYBRID_SOURCE_DIR "/rawlogs/slip_demo_ground_truth_modes.txt";
  ini.replace(ini.find(truth), truth.size(), write("modes.txt", "0\n1 2\n"));
  expect_failure("-c " + write("bad.ini", ini),
                 "modes.txt:2:3: 2 columns; expected: the number of a mode");
}

}  // namespace
}  // namespace hybrid
