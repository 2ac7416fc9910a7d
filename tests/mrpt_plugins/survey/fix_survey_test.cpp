// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/fix_survey.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/gnss_messages_ascii_nmea.h>

namespace hybrid {
namespace {

/// Fixes of a robot that drives a metre a second, stamped `early` seconds before their steps.
std::vector<MovedFix> survey_of_drive(double clock_offset, double early) {
  FixSurvey survey(clock_offset);
  for (int i = 1; i <= 5; ++i) {
    LogStep step;
    step.time = 1000 + i + clock_offset;
    step.odometry = OdometryIncrement();
    step.odometry->mean = mrpt::poses::CPose3D(1, 0, 0, 0, 0, 0);
    auto seen = mrpt::obs::CObservationGPS::Create();
    seen->timestamp = mrpt::Clock::fromDouble(1000 + i - early);
    mrpt::obs::gnss::Message_NMEA_GGA gga;
    gga.fields.latitude_degrees = 50;
    gga.fields.longitude_degrees = 8 + 1e-5 * i;
    gga.fields.fix_quality = 1;
    seen->setMsg(gga);
    step.observations.push_back(seen);
    survey.add(step);
  }
  return survey.release().at("");
}

TEST(FixSurvey, PlacesFixesByTheirStampsOfTheSameClock) {
  for (const double clock_offset : {0.0, 0.5, -100.0}) {
    const auto fixes = survey_of_drive(clock_offset, 0.25);
    ASSERT_EQ(fixes.size(), 4U) << "the first is not confirmed yet";
    for (const MovedFix& fix : fixes) EXPECT_NEAR(fix.antenna.x(), -0.25, 1e-6) << clock_offset;
  }
}

}  // namespace
}  // namespace hybrid
