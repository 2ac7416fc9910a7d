// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/mover_truth.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

TrueMovers read_movers_of(const std::string& text) {
  const TemporaryFile file("movers.csv");
  std::ofstream(file.path()) << text;
  return read_true_movers(file.path());
}

TEST(TrueMovers, AreKeyedByIdAndStep) {
  const TrueMovers truth = read_movers_of("step,id,x,y,z\n0,7,1,2,0\n4,7,1.5,2,0\n4,9,0,0,3\n");
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_EQ(truth.at(7).at(4), Eigen::Vector3d(1.5, 2, 0));
  EXPECT_EQ(truth.at(9).at(4).z(), 3);
}

TEST(TrueMovers, BadFilesAreErrorsThatNameTheLine) {
  for (const char* text : {"step,id,x,y,z\n0,1,2\n", "0,1,2,x,0\n", "0,1,2,3,0\n0,1,2,3,0\n"}) {
    EXPECT_THROW(read_movers_of(text), Error) << text;
  }
  EXPECT_THROW(read_true_movers("/no/such/file.csv"), Error);
}

AssociationDecision decision(std::optional<std::int64_t> landmark, std::int64_t true_id,
                             std::optional<std::int64_t> mover) {
  AssociationDecision out{landmark, true_id};
  out.mover = mover;
  return out;
}

TEST(MoverReport, CountsWhatIsKeptOutAndMeasuresTrajectories) {
  const TrueMovers truth = read_movers_of("0,7,0,0,0\n2,7,2,0,0\n4,7,4,0,0\n");
  // Thing 7 moves, thing 3 stands. Most sightings of mover 1 are of thing 7; mover 5 is false.
  const std::vector<AssociationDecision> decisions = {
      decision({}, 7, 1),  decision({}, 7, 1), decision({}, 7, {}), decision(12, 7, {}),
      decision(11, 3, {}), decision({}, 3, 1), decision({}, 3, 5),  decision({}, 3, {})};
  MoverEstimate mover;
  mover.id = 1;
  mover.states.resize(3);
  mover.keyframes = {0, 1, 2};
  mover.states[0].position = {0, 0.1, 0};
  mover.states[1].position = {2, 0.3, 0};
  mover.states[2].position = {9, 9, 9};  // no truth at step 5
  MoverEstimate invented = mover;
  invented.id = 5;
  mover.states[1].time = 1;
  // At that time the robot is off by 1 m to the left, and so is the mover as it is seen from it.
  const mrpt::poses::CPose3D there(0, 0, 0, 0.5, 0, 0), estimate(0, 1, 0, 0.5, 0, 0);
  const MoverReport report = mover_report(
      decisions, {mover, invented},
      {truth, {0, 2, 5}, {{1.0, {estimate, there}}}, mrpt::poses::CPose3D(0, 0.1, 0, 0, 0, 0)});
  EXPECT_EQ(report.things, 2U);
  EXPECT_EQ(report.sightings, 4U);
  EXPECT_EQ(report.kept_out, 3U);
  EXPECT_EQ(report.followed, 2U);
  EXPECT_EQ(report.false_sightings, 2U);
  EXPECT_EQ(report.states, 2U);
  EXPECT_NEAR(report.mean_m, 0.3, 1e-12);  // 0.2 and 0.4 after the alignment
  EXPECT_NEAR(report.max_m, 0.4, 1e-12);
  EXPECT_NEAR(report.relative_mean_m, 0.7, 1e-12);
  EXPECT_NEAR(report.kept_out_share(), 0.75, 1e-12);
}

}  // namespace
}  // namespace hybrid
