// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "tests/apps/replay_runner.h"

namespace hybrid {

/// Three simulated robots in one world, of which only the first knows where it starts.
class Robots : public ReplayTest {
 protected:
  void SetUp() override {
    const Ran ran = run_app("hybrid-simulate -c " + config("simulate_team_demo.ini") + " -o " +
                            at("team.rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  std::string robot(const std::string& name, int id, const std::string& more = "") const {
    return "[robot." + name + "]\nid = " + std::to_string(id) + "\nrawlog = team_" + name +
           ".rawlog\ntruth_path = team_" + name + "_ground_truth_robot_path.txt\n" + more;
  }
  std::string team(const std::string& plugin, const std::string& more = "") const {
    return write("team.ini",
                 "[log]\ntruth_map = team_anna_ground_truth.txt\n[plugins]\nclasses = " + plugin +
                     "\n" + more + robot("anna", -101) + robot("bert", -102) + robot("carl", -103));
  }
  static double error(const nlohmann::json& summary, int robot) {
    return summary.at("robots").at(robot).at("truth").at("trajectory").at("rmse_m");
  }
};

}  // namespace hybrid
