// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

constexpr double kLatitude = 36.7, kLongitude = -4.5;

/// A place so many metres to the east and north, by the radii of curvature of the ellipsoid of
/// WGS 84.
std::pair<double, double> place(double east, double north) {
  constexpr double kRadius = 6378137, kSquaredEccentricity = 6.69437999014e-3;
  constexpr double kDegree = M_PI / 180;
  const double sine = std::sin(kLatitude * kDegree);
  const double w = 1 - kSquaredEccentricity * sine * sine;
  const double prime_vertical = kRadius / std::sqrt(w);
  const double meridian = prime_vertical * (1 - kSquaredEccentricity) / w;
  return {kLatitude + north / meridian / kDegree,
          kLongitude + east / prime_vertical / std::cos(kLatitude * kDegree) / kDegree};
}

/// Drives 120 m to the north by odometry that looks along x, with a fix each second.
class FixOutputs : public ReplayTest {
 protected:
  void import(bool on_earth) const {
    std::string odometry = "time,x,y,yaw\n";
    std::string fixes = on_earth ? "time,lat,lon\n" : "time,x,y\n";
    for (int t = 0; t <= 60; ++t) {
      odometry += fmt::format("{},{},0,0\n", t, 2 * t);
      const auto [latitude, longitude] = place(5, 2.0 * t);
      fixes += on_earth ? fmt::format("{},{:.10f},{:.10f}\n", t, latitude, longitude)
                        : fmt::format("{},5,{}\n", t, 2 * t);
    }
    write("odometry.csv", odometry);
    write("fixes.csv", fixes);
    const Ran ran = run_app("hybrid-import csv --odometry " + at("odometry.csv") + " --fixes " +
                            at("fixes.csv") + " -o " + at("in.rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  nlohmann::json replayed(const std::string& settings = "") const {
    return summary_of(at("in.rawlog") + " " + settings);
  }
  static bool warns(const nlohmann::json& summary, const std::string& part) {
    for (const auto& warning : summary["warnings"]) {
      if (warning.get<std::string>().find(part) != std::string::npos) return true;
    }
    return false;
  }
};

TEST_F(FixOutputs, TheMapIsOnEarthWhereTheFixesAre) {
  import(true);
  const auto summary = replayed();
  EXPECT_EQ(summary["fixes"]["used"], summary["fixes"]["count"]);
  EXPECT_GE(summary["fixes"]["good"], 58);
  EXPECT_EQ(summary["fixes"]["bias_runs"], 0);
  const auto globe = nlohmann::json::parse(read("out/map.geojson"));
  EXPECT_EQ(globe["crs_name"], "OGC:CRS84");
  const auto& path = globe["features"][0]["geometry"];
  ASSERT_EQ(path["type"], "LineString");
  const auto [latitude, longitude] = place(5, 120);
  EXPECT_NEAR(path["coordinates"].back()[0], longitude, 1e-5);  // a metre
  EXPECT_NEAR(path["coordinates"].back()[1], latitude, 1e-5);
  const auto& fix = globe["features"].back();
  EXPECT_EQ(fix["properties"]["fix"], "good");
  EXPECT_NEAR(fix["geometry"]["coordinates"][0], longitude, 1e-8);  // a millimetre
  EXPECT_NEAR(fix["geometry"]["coordinates"][1], latitude, 1e-8);
  EXPECT_FALSE(warns(summary, "geojson"));
}

TEST_F(FixOutputs, APlaceThatIsGivenByHandWinsAndAConflictIsTold) {
  import(true);
  EXPECT_TRUE(warns(replayed("--set map.origin=36.71,-4.5,90"), "its x axis turned"));
  const auto globe = nlohmann::json::parse(read("out/map.geojson"));
  EXPECT_NEAR(globe["features"][0]["geometry"]["coordinates"][0][1], 36.71, 1e-6);
  EXPECT_FALSE(warns(replayed("--set map.origin=36.7,-4.49994,90"), "geojson"));
}

TEST_F(FixOutputs, AMapFileKeepsThePlace) {
  import(true);
  replayed("--map " + at("a.hmap"));
  ASSERT_EQ(run_app("hybrid-map export --no-pictures -o " + at("ex") + " " + at("a.hmap")).code, 0);
  const auto coordinates = [this](const char* file) {
    return nlohmann::json::parse(read(file))["features"][0]["geometry"]["coordinates"].back();
  };
  const auto exported = coordinates("ex/map.geojson"), told = coordinates("out/map.geojson");
  EXPECT_NEAR(exported[0], told[0], 1e-8);
  EXPECT_NEAR(exported[1], told[1], 1e-8);
}

/// Drives in one street to the north, with things that have ids on both sides.
class FixesInMaps : public FixOutputs {
 protected:
  /// From `from` to `to` [m] along it, 2 m each second, by odometry that is long by a factor.
  void import_part(const std::string& name, int from, int to, double factor) const {
    std::string odometry = "time,x,y,yaw\n", fixes = "time,lat,lon\n";
    std::string detections = "time,range,yaw,id\n";
    for (int t = 0; from + 2 * t <= to; ++t) {
      const int north = from + 2 * t, time = 1000 * from + t;
      odometry += fmt::format("{},{},0,0\n", time, factor * 2 * t);
      const auto [latitude, longitude] = place(5, north);
      fixes += fmt::format("{},{:.10f},{:.10f}\n", time, latitude, longitude);
      for (int k = 0; k < 40; ++k) {
        const double ahead = 12.0 * k - north, left = k % 2 == 0 ? 6 : -6;
        if (ahead < 0 || ahead > 25) continue;
        detections += fmt::format("{},{:.4f},{:.5f},{}\n", time, std::hypot(ahead, left),
                                  std::atan2(left, ahead), k);
      }
    }
    write("odometry.csv", odometry);
    write("fixes.csv", fixes);
    write("detections.csv", detections);
    const Ran ran =
        run_app("hybrid-import csv --odometry " + at("odometry.csv") + " --fixes " +
                at("fixes.csv") + " --detections " + at("detections.csv") + " -o " + at(name));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  /// Expects a path to each of these latitudes and longitudes, within a metre, and no other.
  void expect_paths_to(const std::vector<std::pair<double, double>>& ends) const {
    const auto globe = nlohmann::json::parse(read("out/map.geojson"));
    std::size_t path = 0;
    for (const auto& feature : globe["features"]) {
      if (feature["geometry"]["type"] != "LineString") continue;
      ASSERT_LT(path, ends.size());
      EXPECT_NEAR(feature["geometry"]["coordinates"].back()[1], ends[path].first, 1e-5);
      EXPECT_NEAR(feature["geometry"]["coordinates"].back()[0], ends[path].second, 1e-5);
      ++path;
    }
    EXPECT_EQ(path, ends.size());
  }
};

TEST_F(FixesInMaps, AKnownMapIsWhereItsFixesSay) {
  import_part("a.rawlog", 0, 120, 1);
  import_part("b.rawlog", 60, 240, 1.03);
  summary_of(at("a.rawlog") + " --map " + at("a.hmap"));
  const std::string before = read("a.hmap");
  const auto located = summary_of(at("b.rawlog") + " --map-mode localize --map " + at("a.hmap"));
  EXPECT_EQ(located["fixes"]["used"], located["fixes"]["count"]) << located["dropped"];
  EXPECT_EQ(read("a.hmap"), before);
  const auto extended = summary_of(at("b.rawlog") + " --map " + at("a.hmap"));
  EXPECT_EQ(extended["fixes"]["used"], extended["fixes"]["count"]) << extended["dropped"];
  expect_paths_to({place(5, 240)});
}

TEST_F(FixesInMaps, ADriveElsewhereIsFoundByItsFixes) {
  import_part("a.rawlog", 0, 120, 1);
  import_part("b.rawlog", 300, 420, 1);
  const auto first = summary_of(at("a.rawlog") + " --map " + at("a.hmap"));
  const auto second = summary_of(at("b.rawlog") + " --map " + at("a.hmap"));
  EXPECT_EQ(second["status"], "ok");
  EXPECT_GT(second["landmarks"], first["landmarks"]);
  EXPECT_EQ(second["fixes"]["used"], second["fixes"]["count"]) << second["dropped"];
  expect_paths_to({place(5, 420)});
}

TEST_F(FixesInMaps, RobotsThatDoNotMeetAreInOneMapByTheirFixes) {
  import_part("a.rawlog", 0, 120, 1);
  import_part("b.rawlog", 300, 420, 1);
  const std::string ini =
      write("two.ini",
            "[plugins]\nclasses = BearingRangeKnownIds Fixes\n[robot.a]\nrawlog = a.rawlog\n"
            "[robot.b]\nrawlog = b.rawlog\n");
  const auto summary = summary_of("-c " + ini);
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_EQ(summary["robots"].size(), 2);
  EXPECT_EQ(summary["fixes"]["used"], summary["fixes"]["count"]) << summary["dropped"];
  expect_paths_to({place(5, 120), place(5, 420)});
}

TEST_F(FixesInMaps, APlaceThatIsGivenByHandIsNotExactEnough) {
  import_part("a.rawlog", 0, 120, 1);
  summary_of(at("a.rawlog") + " --set fixes.modes=no --map " + at("a.hmap") +
             " --set \"plugins.classes=BearingRangeKnownIds\" --set map.origin=36.7,-4.5,90");
  import_part("b.rawlog", 60, 240, 1);
  const auto summary = summary_of(at("b.rawlog") + " --map " + at("a.hmap"));
  EXPECT_EQ(summary["fixes"]["used"], 0);
}

TEST_F(FixesInMaps, MapsThatShareNothingAreJoinedByTheirPlacesOnEarth) {
  import_part("a.rawlog", 0, 120, 1);
  import_part("b.rawlog", 300, 420, 1);
  for (const std::string name : {"a", "b"}) {
    summary_of(at(name + ".rawlog") + " --map " + at(name + ".hmap"));
  }
  const Ran ran =
      run_app("hybrid-map join -o " + at("c.hmap") + " " + at("a.hmap") + " " + at("b.hmap"));
  ASSERT_EQ(ran.code, 0) << ran.text;
  EXPECT_NE(ran.text.find("by fixes of satellites, 0 landmarks"), std::string::npos) << ran.text;
  // Both drives begin where their maps do.
  const std::size_t at_place = ran.text.find("at (");
  ASSERT_NE(at_place, std::string::npos) << ran.text;
  EXPECT_NEAR(std::stod(ran.text.substr(at_place + 4)), 300, 1) << ran.text;
}

TEST_F(FixOutputs, ALogWithoutOdometryIsMappedByItsFixes) {
  // Two antennas with fixes to centimetres, and a third receiver that is 147 m off.
  const auto summary = summary_of("/usr/share/mrpt/datasets/test_rtk_path.rawlog");
  EXPECT_EQ(summary["status"], "ok") << summary["message"];
  EXPECT_EQ(summary["fixes"]["used"], summary["fixes"]["count"]) << summary["dropped"];
  EXPECT_GE(summary["fixes"]["good"], 600);
  EXPECT_LE(summary["fixes"]["biased"], 3);
  const std::string fixes = read("out/fixes.csv");
  std::istringstream rows(fixes);
  for (std::string row; std::getline(rows, row);) {
    if (row.find("GPS_RTK_REAR") == std::string::npos) continue;
    EXPECT_NE(row.find(",false,"), std::string::npos) << row;
  }
  EXPECT_FALSE(warns(summary, "path against odometry")) << "there is none";
  EXPECT_NE(summary["health"].dump().find("76 of them of receiver 'GPS_RTK_REAR'"),
            std::string::npos);
  const auto globe = nlohmann::json::parse(read("out/map.geojson"));
  const auto& path = globe["features"][0]["geometry"]["coordinates"];
  ASSERT_GT(path.size(), 100U);
}

TEST_F(FixOutputs, LocalAxesAreNotOnEarth) {
  import(false);
  EXPECT_TRUE(warns(replayed(), "not on earth"));
  EXPECT_FALSE(std::filesystem::exists(at("out/map.geojson")));
}

}  // namespace
}  // namespace hybrid
