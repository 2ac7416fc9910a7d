// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "mrpt_plugins/input/odometry_stop.h"

#include <gtest/gtest.h>

#include <functional>

namespace hybrid {
namespace {

using Speed = std::function<double(double time)>;

/// Stops in half a minute of odometry, by steps of a period [s] whose ways are those of a speed.
std::size_t stops(const Speed& speed, double period, double turn = 0, double first = 0) {
  OdometryStop stop;
  for (double time = first; time < 30; time += period) {
    double way = 0;  // from a log of a hundred hertz
    for (int i = 0; i < 100; ++i) way += speed(time - period * i / 100) * period / 100;
    Eigen::Isometry3d motion(Eigen::Translation3d(way, 0, 0));
    if (way == 0) motion.rotate(Eigen::AngleAxisd(turn * period, Eigen::Vector3d::UnitZ()));
    stop.take(time, motion);
  }
  return stop.count();
}

/// Full speed but for a rest, which takes `ramp` seconds to begin and to end.
Speed with_rest(double full, double from, double to, double ramp) {
  return [=](double time) {
    if (time < from || time > to) return full;
    if (time > from + ramp && time < to - ramp) return 0.0;
    return full * (ramp > 0 ? std::max(from + ramp - time, time - to + ramp) / ramp : 0.0);
  };
}

TEST(OdometryStop, OfADriverThatDiesIsTold) {
  for (const double first : {0.0, 0.02, 0.05, 0.08}) {
    EXPECT_EQ(stops(with_rest(5, 10, 20, 0), 0.1, 0, first), 1U) << first;
    EXPECT_EQ(stops(with_rest(1.5, 10, 20, 0), 0.1, 0, first), 1U) << first;
  }
  const Speed leaps = [](double time) {
    return time > 10 && time < 20 ? 0.0 : time > 20 && time < 20.1 ? 500.0 : 5.0;
  };
  EXPECT_EQ(stops(leaps, 0.1), 1U);
}

TEST(OdometryStop, OfARobotIsNot) {
  EXPECT_EQ(stops(with_rest(5, 10, 20, 2), 0.1), 0U);
  EXPECT_EQ(stops(with_rest(0.3, 10, 20, 0), 0.1), 0U);   // slow
  EXPECT_EQ(stops(with_rest(5, 10, 10.8, 0), 0.1), 0U);   // short
  EXPECT_EQ(stops(with_rest(2, 10, 20, 0), 1), 0U);       // not to be seen at that rate
  EXPECT_EQ(stops(with_rest(5, 10, 20, 0), 0.1, 1), 0U);  // it turns
  EXPECT_EQ(stops(with_rest(5, 10, 40, 0), 0.1), 0U);     // it ends there
  EXPECT_EQ(stops(with_rest(5, -1, 10, 0), 0.1), 0U);     // it begins there
}

}  // namespace
}  // namespace hybrid
