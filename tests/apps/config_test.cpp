// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class Configuration : public ScratchFolder {
 protected:
  /// The message of a replay with one value, which must be refused before a log is opened.
  std::string refusal(const std::string& setting) const {
    const Ran ran = run_app("hybrid-replay --print-config -o " + at("out") + " --set " + setting);
    EXPECT_EQ(ran.code, 1) << setting << "\n" << ran.text;
    return ran.text;
  }
};

// An absurd number is named by its key, and not by what it does to the equations later.
TEST_F(Configuration, EveryNumberHasBounds) {
  for (const char* program :
       {"hybrid-replay", "hybrid-simulate", "hybrid-experiment", "hybrid-pgo"}) {
    std::istringstream lines(run_app(std::string(program) + " --print-config").text);
    int numbers = 0;
    for (std::string line; std::getline(lines, line);) {
      const std::size_t type = line.rfind('(');
      if (line.empty() || line[0] != '#' || type == std::string::npos) continue;
      const std::string range = line.substr(type);
      if (range.find("number") == std::string::npos) continue;
      ++numbers;
      const bool seed = line.find("seed") != std::string::npos || line.find("Same seed") == 2;
      EXPECT_TRUE(seed || range.find('<') != std::string::npos) << program << ": " << line;
    }
    EXPECT_GT(numbers, 10) << program;
  }
}

TEST_F(Configuration, AbsurdNumbersAreRefusedByName) {
  for (const char* value : {"1e300", "1e9", "1e-300", "-1", "nan", "0"}) {
    for (const char* key : {"prior.sigma_m", "prior.sigma_rad", "odometry.lost_sigma_m",
                            "odometry.lost_sigma_deg", "odometry.sigmas", "sensor.max_range"}) {
      const std::string name = std::string(key).substr(std::string(key).find('.') + 1);
      EXPECT_NE(refusal(std::string(key) + "=" + value).find("] " + name + " = '" + value + "' is"),
                std::string::npos);
    }
  }
  EXPECT_NE(refusal("sensor.sigma_range=1e-9").find("number, >= 1e-06, <= 1000, or 0"),
            std::string::npos);
}

TEST_F(Configuration, AFolderInPlaceOfAFileIsNamedByItsKey) {
  for (const char* key :
       {"rawlog", "truth_path", "truth_map", "truth_movers", "truth_associations"}) {
    const std::string text = refusal(std::string("log.") + key + "=" + at(""));
    EXPECT_NE(text.find(std::string("] ") + key), std::string::npos) << text;
    EXPECT_NE(text.find("is a folder, not a file"), std::string::npos) << text;
  }
}

TEST_F(Configuration, PathsOfSimulationsAreOfBoundedLength) {
  const std::string ini = write("s.ini", "[path]\nstep = 1e-6\nradius = 1e6\n");
  const Ran ran = run_app("hybrid-simulate -c " + ini + " -o " + at("s.rawlog"));
  EXPECT_EQ(ran.code, 1);
  EXPECT_NE(ran.text.find("more than 1000000 frames"), std::string::npos) << ran.text;
}

}  // namespace
}  // namespace hybrid
