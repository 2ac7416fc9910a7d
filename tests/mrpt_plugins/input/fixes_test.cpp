// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/fixes.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/gnss_messages_ascii_nmea.h>

#include <cmath>
#include <limits>

namespace hybrid {
namespace {

mrpt::obs::CObservationGPS satellite_fix(double latitude, double longitude, int quality = 1,
                                         double time = 10) {
  mrpt::obs::CObservationGPS out;
  out.timestamp = mrpt::Clock::fromDouble(time);
  out.sensorLabel = "GPS";
  mrpt::obs::gnss::Message_NMEA_GGA gga;
  gga.fields.latitude_degrees = latitude;
  gga.fields.longitude_degrees = longitude;
  gga.fields.altitude_meters = 50;
  gga.fields.fix_quality = static_cast<std::uint8_t>(quality);
  out.setMsg(gga);
  return out;
}

TEST(FixIn, SigmasAreThoseOfTheQuality) {
  DropReport report;
  EXPECT_DOUBLE_EQ(fix_in(satellite_fix(36.7, -4.5, 1), report)->fix.sigma, 2);
  EXPECT_DOUBLE_EQ(fix_in(satellite_fix(36.7, -4.5, 2), report)->fix.sigma, 1);
  EXPECT_DOUBLE_EQ(fix_in(satellite_fix(36.7, -4.5, 4), report)->fix.sigma, 0.02);
  auto diluted = satellite_fix(36.7, -4.5, 1);
  auto& fields = diluted.getMsgByClass<mrpt::obs::gnss::Message_NMEA_GGA>().fields;
  fields.thereis_HDOP = true;
  fields.HDOP = 3;
  EXPECT_DOUBLE_EQ(fix_in(diluted, report)->fix.sigma, 6);
  EXPECT_TRUE(report.empty());
}

TEST(FixIn, WhatIsNoPlaceIsDroppedAndCounted) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  DropReport report;
  EXPECT_FALSE(fix_in(satellite_fix(36.7, -4.5, 0), report));
  EXPECT_FALSE(fix_in(satellite_fix(0, 0), report));
  EXPECT_FALSE(fix_in(satellite_fix(none, 1), report));
  EXPECT_FALSE(fix_in(satellite_fix(91, 1), report));
  auto far = satellite_fix(36.7, -4.5);
  far.sensorPose.x(1e5);
  EXPECT_FALSE(fix_in(far, report));
  std::size_t all = 0;
  for (const auto& [reason, count] : report) all += count;
  EXPECT_EQ(all, 5U);
  EXPECT_EQ(report.size(), 4U);
}

TEST(FixCollector, FixesArePlacedByTheirOwnTimes) {
  DropReport report;
  FixCollector collector;
  OdometryIncrement forward;
  forward.mean = mrpt::poses::CPose3D(2, 0, 0, 0, 0, 0);
  collector.move(8, std::nullopt, report);
  collector.release();
  collector.move(10, forward, report);
  for (const double time : {9.0, 10.0, 10.5}) {
    collector.add(*fix_in(satellite_fix(36.7, -4.5 + 1e-6 * time, 1, time), report), report);
  }
  const std::vector<LoggedFix> fixes = collector.release();
  ASSERT_EQ(fixes.size(), 3U);
  EXPECT_NEAR(fixes[0].fix.T_keyframe_robot.translation().x(), -1, 1e-9);
  EXPECT_NEAR(fixes[1].fix.T_keyframe_robot.translation().x(), 0, 1e-9);
  EXPECT_NEAR(fixes[2].fix.T_keyframe_robot.translation().x(), 0.5, 1e-9);
  EXPECT_TRUE(report.empty());
}

TEST(DatumFinder, ADatumThatMostFixesContradictIsTold) {
  DropReport report;
  DatumFinder finder;
  const auto take = [&](double latitude) {
    return finder.to_local(*fix_in(satellite_fix(latitude, 8), report), report).has_value();
  };
  EXPECT_FALSE(take(-50)) << "no other confirms it yet";
  EXPECT_TRUE(take(-50.0001));
  EXPECT_TRUE(take(-50.0002));
  EXPECT_FALSE(take(50));
  EXPECT_FALSE(take(50.0001));
  EXPECT_FALSE(finder.is_contradicted());
  EXPECT_FALSE(take(50.0002));
  EXPECT_TRUE(finder.is_contradicted());
  EXPECT_EQ(report["fix dropped: farther than 1,000 km from the datum"], 3U);
}

TEST(FixCollector, ARepeatedFixCountsOnce) {
  DropReport report;
  FixCollector collector;
  collector.move(10, std::nullopt, report);
  for (int i = 0; i < 5; ++i) collector.add(*fix_in(satellite_fix(36.7, -4.5), report), report);
  EXPECT_EQ(collector.release().size(), 1U);
  EXPECT_EQ(report["fix dropped: the receiver repeats the last one"], 4U);
}

}  // namespace
}  // namespace hybrid
