// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A scan that cannot be used leaves the mapper as it was.
#include <gtest/gtest.h>

#include <random>

#include "libhybrid/core/error.h"
#include "libhybrid/scans/scan_mapper.h"
#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

/// Two rounds along the ring of corridors, by true odometry.
class Rounds {
 public:
  bool goes_on() const { return next_ < way_.size(); }
  void add_to(ScanMapper& mapper, KeyframeRule rule = KeyframeRule::kByMotion) const {
    std::optional<SE2> motion;
    if (next_ > 0) motion = way_[next_ - 1].between(way_[next_]);
    std::mt19937 random(static_cast<unsigned>(next_));
    mapper.add(scan_points(plan_.scan(way_[next_], 91, 0.01, random)), motion, rule);
  }
  void go_on() { ++next_; }

 private:
  testing::FloorPlan plan_ = testing::ring();
  std::vector<SE2> way_ = testing::way_around_ring(2, 0.3);
  std::size_t next_ = 0;
};

/// Stored scans whose covariance is none: each keyframe that is matched with them throws.
TEST(RefusedScans, KeyframesThatThrowAreLeftOut) {
  Rounds first;
  ScanMapper known;
  for (; first.goes_on(); first.go_on()) first.add_to(known);
  std::vector<StoredScans> stored;
  for (const LocalScans& scans : local_scans(known.tracker())) {
    stored.push_back(
        {{known.pose(scans.anchor), 1e-3 * Eigen::Matrix3d::Identity()}, scans.points});
  }
  for (std::size_t i = 0; i < stored.size(); i += 4) stored[i].T_map_anchor.covariance.setZero();
  ScanMapper mapper;
  mapper.adopt(stored, {SE2(), 1e-4 * Eigen::Matrix3d::Identity()});
  Rounds second;
  std::size_t refused = 0, scans = 0;
  for (; second.goes_on(); second.go_on(), ++scans) {
    const std::vector<SE2> before = mapper.path();
    const std::size_t keyframes = mapper.tracker().keyframes().size();
    try {
      second.add_to(mapper);
    } catch (const Error&) {
      ++refused;
      const std::vector<SE2> after = mapper.path();
      ASSERT_EQ(after.size(), before.size());
      for (std::size_t i = 0; i < after.size(); ++i) ASSERT_EQ(after[i].log(), before[i].log());
      ASSERT_EQ(mapper.tracker().keyframes().size(), keyframes);
      second.add_to(mapper, KeyframeRule::kNever);
    }
    ASSERT_EQ(mapper.path().size(), before.size() + 1);
  }
  EXPECT_GT(refused, 3U);
  // Some 190 to 320 of 500, by the noise of the scans; those after them are mapped.
  EXPECT_LT(refused, 4 * scans / 5);
  EXPECT_GT(mapper.tracker().keyframes().size(), scans / 8);
  mapper.finish();
  for (std::size_t k = 0; k < mapper.tracker().keyframes().size(); ++k) mapper.pose(k);
}

}  // namespace
}  // namespace hybrid
