// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <string>

#include "tests/apps/cloud_log.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

/// A map file of a hall by clouds alone, and a second drive in it, the other way round.
class CloudMapFile : public CloudLogTest {
 protected:
  void SetUp() override {
    CloudLogTest::SetUp();
    const std::vector<SE3> way = testing::way_along_hall(0.5, -20, 20);
    const std::vector<SE3> back = testing::way_along_hall(0.5, 12, -12);
    write_clouds("first", testing::long_hall(), way, 4);
    write_clouds("second", testing::long_hall(), back, 5, 1e9);
    start_ = way[0].between(back[0]);
    for (const std::string name : {"first", "second"}) {
      import(name, "--odometry " + at(name + "_odometry.txt"));
    }
    build("first", "a.hmap");
  }
  void build(const std::string& log, const std::string& map) const {
    const Ran built = run_replay(at(log + ".rawlog") + kShort + " --no-pictures --map " + at(map) +
                                 " -o " + at(log + "_map"));
    ASSERT_EQ(built.code, 0) << built.text;
  }
  Json replayed(const std::string& arguments, int code = 0) const {
    return summary_of(at("second.rawlog") + kShort + " --map " + at("a.hmap") + " " + arguments,
                      code);
  }
  Json info(const std::string& map = "a.hmap") const {
    return Json::parse(run_app("hybrid-map info --json " + at(map)).text, nullptr, false);
  }
  /// How far the path of the second drive begins from the truth, in the frame of the map, which is
  /// bent by a decimetre.
  double error_at_start(const std::string& folder = "out") const {
    std::istringstream path(read(folder + "/trajectory.tum"));
    std::string line;
    while (std::getline(path, line) && line[0] == '#') {
    }
    double t = 0;
    Eigen::Vector3d at;
    std::istringstream(line) >> t >> at.x() >> at.y() >> at.z();
    return (at - start_.translation()).norm();
  }

  static constexpr const char* kShort = " --set PointClouds.map_length=2";
  SE3 start_;
};

TEST_F(CloudMapFile, ALaterDriveIsFoundInItAndExtendsIt) {
  const int before = info().at("local_clouds");
  EXPECT_GT(before, 2);
  EXPECT_EQ(run_app("hybrid-map check " + at("a.hmap")).code, 0);
  const std::string as_built = read("a.hmap");
  const Json located = replayed("--map-mode localize");
  EXPECT_EQ(located["status"], "ok") << located["message"];
  EXPECT_TRUE(located["localized_at"].is_number());
  EXPECT_GT(located["plugins"]["known_places_accepted"].get<int>(), 3);
  EXPECT_LT(error_at_start(), 0.2);
  EXPECT_TRUE(read("a.hmap") == as_built);

  const auto& t = start_.translation();
  const double yaw = start_.rotation().log().z() * 180 / M_PI;
  const Json given = replayed(fmt::format("--map-mode localize --set \"map.start={} {} {} {} 0 0\"",
                                          t.x() + 0.3, t.y(), t.z(), yaw));
  EXPECT_EQ(given["status"], "ok") << given["message"];
  EXPECT_LT(error_at_start(), 0.2);

  const Json extended = replayed("");
  EXPECT_EQ(extended["status"], "ok") << extended["message"];
  EXPECT_GT(info().at("local_clouds").get<int>(), before);
  EXPECT_LT(error_at_start(), 0.2);
  const Ran exported = run_app("hybrid-map export " + at("a.hmap") + " -o " + at("exported"));
  EXPECT_EQ(exported.code, 0) << exported.text;
  EXPECT_GT(read("exported/cloud.ply").size(), 100'000U);
  ASSERT_EQ(run_app("hybrid-map prune --session 2 " + at("a.hmap")).code, 0);
  EXPECT_EQ(info().at("local_clouds"), before);
}

TEST_F(CloudMapFile, ADriveElsewhereIsNotFoundInIt) {
  write_clouds("second", testing::long_hall(9), testing::way_along_hall(0.5, 12, -12), 5, 1e9);
  std::filesystem::remove(at("second.rawlog"));
  import("second", "--odometry " + at("second_odometry.txt"));
  const Json before = info();
  for (const std::string arguments :
       {"--map-mode localize", "", "--map-mode localize --set \"map.start=0 0 0 0 0 0\""}) {
    SCOPED_TRACE(arguments);
    const Json lost = replayed(arguments, 2);
    EXPECT_EQ(lost["status"], "partial");
    EXPECT_TRUE(lost["localized_at"].is_null());
    EXPECT_EQ(info(), before);
  }
}

TEST_F(CloudMapFile, TwoRobotsMeetByTheirClouds) {
  const Json both = summary_of(at("first.rawlog") + " " + at("second.rawlog") + kShort);
  EXPECT_EQ(both["status"], "ok") << both["message"];
  EXPECT_GE(both["plugins"]["closures_between_robots"], 3);
  EXPECT_LT(error_at_start("out/second"), 0.2);
}

TEST_F(CloudMapFile, TwoMapsAreJoinedByTheirClouds) {
  build("second", "b.hmap");
  const Ran joined =
      run_app("hybrid-map join " + at("a.hmap") + " " + at("b.hmap") + " -o " + at("c.hmap"));
  ASSERT_EQ(joined.code, 0) << joined.text;
  EXPECT_NE(joined.text.find("matches of clouds"), std::string::npos) << joined.text;
  EXPECT_EQ(
      info("c.hmap").at("local_clouds").get<int>(),
      info("a.hmap").at("local_clouds").get<int>() + info("b.hmap").at("local_clouds").get<int>());
}

}  // namespace
}  // namespace hybrid
