// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A log whose odometry is so bad that another start leads lower.
#include <string>

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

class ReplayStart : public ReplayTest {
 protected:
  /// Two rounds of 251 m with an error of heading of `sigma_deg` a metre, and its INI.
  std::string round(const std::string& sigma_deg, const std::string& seed = "2") const {
    const std::string scenario =
        write("sim.ini", "[simulation]\nseed = " + seed +
                             "\n"
                             "[world]\nlandmarks = 80\nmin_spacing = 3\n"
                             "min_corner = -48 -8 0\nmax_corner = 48 88 0\n"
                             "[path]\nshape = circle\nradius = 40\nlaps = 2\nstep = 1\n"
                             "[odometry]\nsigma_translation = 0.05\nsigma_yaw_deg = " +
                             sigma_deg +
                             "\n[sensor]\nmax_range = 10\nfov_yaw_deg = 200\n"
                             "sigma_range = 0.05\nsigma_yaw_deg = 0.5\n");
    const Ran ran = run_app("hybrid-simulate -c " + scenario + " -o " + at("round.rawlog"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    return write("round.ini",
                 "[log]\nrawlog = round.rawlog\n[plugins]\nclasses = BearingRangeKnownIds\n"
                 "[sensor]\nnoise = stated\n");
  }
};

// With the loss that misread ids ask for, the online one would do.
TEST_F(ReplayStart, AChordalOneEndsLowerWhereTheHeadingIsBad) {
  const std::string ini = round("10", "3") + " --set BearingRangeKnownIds.huber_width=0";
  const auto batch = summary_of("-c " + ini + " --set solver.mode=batch");
  const auto online = summary_of("-c " + ini);
  EXPECT_EQ(online["mode"], "bounded");
  const double best = batch["cost"];
  EXPECT_LT(best, 1500.0);  // of about 1500 residuals beside those of odometry
  EXPECT_NEAR(online["cost"].get<double>(), best, 0.01 * best);
  const auto& starts = online["plugins"];
  EXPECT_GT(starts["objective_from_online"].get<double>(), 10000.0);
  EXPECT_NEAR(starts["objective_from_chordal"].get<double>(), online["objective"].get<double>(),
              0.01 * best);
}

/// Poses step along tangents beside landmarks, so that long steps do not part them.
TEST_F(ReplayStart, TheOnlineOneEndsLowerWhereTheHeadingIsLessBad) {
  const auto online = summary_of("-c " + round("5"));
  EXPECT_LT(online["cost"].get<double>(), 1500.0);
  const auto& starts = online["plugins"];
  EXPECT_DOUBLE_EQ(starts["objective_from_online"].get<double>(),
                   online["objective"].get<double>());
  EXPECT_GT(starts["objective_from_chordal"].get<double>(), online["objective"].get<double>() + 10);
}

TEST_F(ReplayStart, NoOtherIsTriedWhereNoiseExplainsTheResult) {
  const std::string ini = round("0.5");
  for (const char* mode : {"batch", "bounded"}) {
    const auto summary = summary_of("-c " + ini + " --set solver.mode=" + mode);
    EXPECT_FALSE(summary["plugins"].contains("objective_from_chordal")) << mode;
  }
}

}  // namespace
}  // namespace hybrid
