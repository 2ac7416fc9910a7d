// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "tests/apps/replay_runner.h"
#include "tests/apps/scan_log.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

/// A map file of the ring of corridors by its laser scans alone, and a second drive in it.
class ScanMapFileTest : public ReplayTest {
 protected:
  void SetUp() override {
    ScanLog first;
    first.way = testing::way_around_ring(1, 0.1);
    write_scan_log(at("first.rawlog"), first);
    ScanLog second;
    second.way.assign(first.way.begin() + 150, first.way.end() - 50);
    second.time = [](std::size_t i) { return 2e9 + 0.2 * double(i); };
    start_ = first.way.front().between(second.way.front());
    second_ = second;
    write_scan_log(at("second.rawlog"), second);
    const Ran built = run_replay(at("first.rawlog") + " --no-pictures --map " + at("a.hmap") +
                                 " -o " + at("first"));
    ASSERT_EQ(built.code, 0) << built.text;
  }
  Json replayed(const std::string& arguments, int code = 0) const {
    return summary_of(at("second.rawlog") + " --map " + at("a.hmap") + " " + arguments, code);
  }
  Json info() const {
    return Json::parse(run_app("hybrid-map info --json " + at("a.hmap")).text, nullptr, false);
  }
  /// The largest distance of the last path from the truth, in the frame of the map.
  double error() const {
    std::ifstream file(folder / "out" / "trajectory.tum");
    double most = 0;
    std::size_t i = 0;
    for (std::string line; std::getline(file, line);) {
      if (line.empty() || line[0] == '#') continue;
      double t = 0, x = 0, y = 0;
      std::istringstream(line) >> t >> x >> y;
      const SE2 truth = start_ * second_.way.front().between(second_.way.at(i++));
      most = std::max(most, std::hypot(x - truth.x(), y - truth.y()));
    }
    EXPECT_EQ(i, second_.way.size());
    return most;
  }
  std::string given_start() const {
    std::ostringstream out;
    out << "--set \"map.start=" << start_.x() + 0.2 << " " << start_.y() - 0.1 << " "
        << start_.angle() * 180 / M_PI << "\" --set map.start_sigma_m=0.3 ";
    return out.str();
  }

  SE2 start_;
  ScanLog second_;
};

TEST_F(ScanMapFileTest, KeepsLocalMapsAndIsWell) {
  EXPECT_GT(info().at("local_maps").get<int>(), 5);
  EXPECT_EQ(info().at("landmarks"), 0);
  const Ran checked = run_app("hybrid-map check " + at("a.hmap"));
  EXPECT_EQ(checked.code, 0) << checked.text;
  EXPECT_NE(checked.text.find("all well"), std::string::npos);
}

TEST_F(ScanMapFileTest, LocalizesFromAGivenStartAndLeavesTheMap) {
  const std::string before = read("a.hmap");
  const Json summary = replayed("--map-mode localize " + given_start());
  EXPECT_GT(summary.at("plugins").at("known_places_accepted").get<double>(), 5);
  EXPECT_LT(error(), 0.3);
  EXPECT_TRUE(read("a.hmap") == before);
}

TEST_F(ScanMapFileTest, ARoughStartIsMadeExactByScans) {
  for (const double off : {-0.8, 0.8}) {
    SCOPED_TRACE(off);
    std::ostringstream start;
    start << "--set \"map.start=" << start_.x() + off << " " << start_.y() + off << " "
          << start_.angle() * 180 / M_PI + 8 * off << "\"";
    replayed("--map-mode localize " + start.str());
    EXPECT_LT(error(), 0.3);
  }
}

TEST_F(ScanMapFileTest, FindsItsStartByScans) {
  const Json summary = replayed("--map-mode localize");
  EXPECT_TRUE(summary.at("localized_at").is_number()) << summary.at("message");
  EXPECT_LT(error(), 0.3);
}

TEST_F(ScanMapFileTest, RobotsMeetByTheirScans) {
  const Json both = summary_of(at("first.rawlog") + " " + at("second.rawlog"));
  EXPECT_EQ(both["status"], "ok") << both["message"];
  EXPECT_GE(both["plugins"]["closures_between_robots"], 3);
}

TEST_F(ScanMapFileTest, ExtendsTheMap) {
  const int before = info().at("local_maps");
  replayed("");
  EXPECT_LT(error(), 0.3);
  EXPECT_GT(info().at("local_maps").get<int>(), before);
  EXPECT_EQ(info().at("sessions").size(), 2U);
  const Ran pruned = run_app("hybrid-map prune --session 2 " + at("a.hmap"));
  EXPECT_EQ(pruned.code, 0) << pruned.text;
  EXPECT_EQ(info().at("local_maps"), before);
}

TEST_F(ScanMapFileTest, AWrongStartIsNotTaken) {
  const Json before = info();
  for (const std::string mode : {"localize", "extend"}) {
    for (const std::string start : {"5 5 90", "200 100 0"}) {
      SCOPED_TRACE(mode + " from " + start);
      const Json summary = replayed("--map-mode " + mode + " --set \"map.start=" + start + "\"", 2);
      EXPECT_EQ(summary.at("status"), "partial");
      EXPECT_NE(summary.at("message").get<std::string>().find("not found in"), std::string::npos);
      EXPECT_TRUE(summary.at("localized_at").is_null());
      EXPECT_EQ(info(), before);
    }
  }
}

// Without closures the two laps of a map do not lie on each other, and its local maps are wrong by
// what their covariances say. Where the second drive finds them to be is where they are looked for.
TEST_F(ScanMapFileTest, AMapThatIsBentIsLookedAtWhereItIsFound) {
  ScanLog laps;
  laps.way = testing::way_around_ring(2, 0.1);
  write_scan_log(at("laps.rawlog"), laps);
  const Ran built = run_replay(at("laps.rawlog") + " --no-pictures --set LaserScans.closures=no " +
                               "--map " + at("bent.hmap") + " -o " + at("laps"));
  ASSERT_EQ(built.code, 0) << built.text;
  const Json summary =
      summary_of(at("second.rawlog") + " --map " + at("bent.hmap") + " --map-mode localize");
  const Json agreement = entry(summary, "agreement with the map");
  ASSERT_FALSE(agreement.is_null());
  EXPECT_GT(agreement.at("value").get<double>(), 0.97);
}

TEST_F(ScanMapFileTest, TheGridIsOfAllThatTheMapHolds) {
  const auto occupied = [this](const std::string& file) {
    const std::string grid = read(file);
    return std::count(grid.begin(), grid.end(), '\0');
  };
  const auto exported = [&] {
    const Ran ran = run_app("hybrid-map export " + at("a.hmap") + " -o " + at("export"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return occupied("export/map.pgm");
  };
  const auto first = occupied("first/map.pgm");
  EXPECT_GT(exported(), first / 2);
  EXPECT_TRUE(std::filesystem::exists(at("export/map.yaml")));
  replayed("");
  EXPECT_GT(occupied("out/map.pgm"), first * 2 / 3);
  EXPECT_GT(exported(), first / 2);
}

TEST_F(ScanMapFileTest, AnotherPlaceIsNotFound) {
  const std::string before = read("a.hmap");
  ScanLog other;
  std::mt19937 random(7);
  other.plan = testing::pillars(60, random);
  other.way.clear();
  for (int i = 0; i < 250; ++i) other.way.emplace_back(0.1 * i - 12, 0.3, 0.1);
  write_scan_log(at("second.rawlog"), other);
  const Json summary = replayed("", 2);
  EXPECT_EQ(summary.at("status"), "partial");
  EXPECT_TRUE(read("a.hmap") == before);
}

/// Maps of two drives of which each has a part of the ring that the other lacks.
class ScanMapJoinTest : public ReplayTest {
 protected:
  static std::vector<SE2> part(std::size_t from, std::size_t to) {
    const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
    return {way.begin() + long(from), way.begin() + long(to)};
  }
  void log(const std::string& name, const std::vector<SE2>& way, double begin) const {
    ScanLog log;
    log.way = way;
    log.time = [begin](std::size_t i) { return begin + 0.2 * double(i); };
    write_scan_log(at(name + ".rawlog"), log);
  }
  void map(const std::string& name) const {
    const Ran built = run_replay(at(name + ".rawlog") + " --no-pictures --map " +
                                 at(name + ".hmap") + " -o " + at(name));
    ASSERT_EQ(built.code, 0) << built.text;
  }
  Ran join(const std::string& other) const {
    return run_app("hybrid-map join " + at("a.hmap") + " " + at(other + ".hmap") + " -o " +
                   at("joined.hmap"));
  }
};

TEST_F(ScanMapJoinTest, ALogIsLocatedInTheMapOfTwoDrives) {
  log("a", part(0, 420), 1e9);
  log("b", part(160, 630), 2e9);
  map("a");
  map("b");
  const Ran joined = join("b");
  ASSERT_EQ(joined.code, 0) << joined.text;
  EXPECT_NE(joined.text.find("matches of laser scans"), std::string::npos) << joined.text;
  const Json info =
      Json::parse(run_app("hybrid-map info --json " + at("joined.hmap")).text, nullptr, false);
  EXPECT_EQ(info.at("sessions").size(), 2U);
  const Ran checked = run_app("hybrid-map check " + at("joined.hmap"));
  EXPECT_NE(checked.text.find("all well"), std::string::npos) << checked.text;
  // A drive where only the second was, in the frame of the first.
  log("c", part(430, 620), 3e9);
  summary_of(at("c.rawlog") + " --map " + at("joined.hmap") + " --map-mode localize");
  std::ifstream file(folder / "out" / "trajectory.tum");
  const SE2 first = part(0, 1).front();
  const std::vector<SE2> way = part(430, 620);
  std::size_t i = 0;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    double t = 0, x = 0, y = 0;
    std::istringstream(line) >> t >> x >> y;
    const SE2 truth = first.between(way.at(i++));
    ASSERT_LT(std::hypot(x - truth.x(), y - truth.y()), 0.4) << i;
  }
  EXPECT_EQ(i, way.size());
  const Ran again = join("b");
  EXPECT_EQ(again.code, 1);
  EXPECT_NE(again.text.find("holds a map already"), std::string::npos) << again.text;
}

TEST_F(ScanMapJoinTest, MapsOfTwoBuildingsAreRefusedWithTheReason) {
  log("a", part(0, 420), 1e9);
  map("a");
  ScanLog other;
  std::mt19937 random(7);
  other.plan = testing::pillars(60, random);
  other.way.clear();
  for (int i = 0; i < 250; ++i) other.way.emplace_back(0.1 * i - 12, 0.3, 0.1);
  other.time = [](std::size_t i) { return 2e9 + 0.2 * double(i); };
  write_scan_log(at("other.rawlog"), other);
  map("other");
  const Ran refused = join("other");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.text.find("stretch"), std::string::npos) << refused.text;
  EXPECT_NE(refused.text.find("nothing was merged"), std::string::npos) << refused.text;
  EXPECT_FALSE(std::filesystem::exists(folder / "joined.hmap"));
}

}  // namespace
}  // namespace hybrid
