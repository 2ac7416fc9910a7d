// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

using AssociationReplay = ReplayTest;

// MRPT's kf-slam with joint compatibility ends with a path rms of 0.075 m.
TEST_F(AssociationReplay, DemoWithoutIdsGivesTheTwentyLandmarks) {
  const auto summary = summary_of("-c " + config("kf_slam_6d_demo_da.ini"));
  EXPECT_EQ(summary["status"], "ok");
  EXPECT_EQ(summary["landmarks"], 20);
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"], 0.03);
}

class Methods : public ReplayTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(Methods, AllFindTheLandmarksOfTheDemo) {
  const std::string ini = write("a.ini", read_file(config("kf_slam_6d_demo_da.ini")) +
                                             "\n[BearingRangeAssociation]\nmethod = " + GetParam());
  const auto summary = summary_of("-c " + ini);
  EXPECT_GE(summary["landmarks"], 20);
  EXPECT_LE(summary["landmarks"], 21);
  EXPECT_LT(summary["truth"]["trajectory"]["rmse_m"], 0.08);
}

INSTANTIATE_TEST_SUITE_P(Method, Methods, ::testing::Values("hypotheses", "nearest", "jcbb"));

}  // namespace
}  // namespace hybrid
