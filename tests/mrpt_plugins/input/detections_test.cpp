// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/detections.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservationBearingRange.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/system/datetime.h>

#include <cmath>
#include <limits>

#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace hybrid {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

CObservationClassedBearingRange classed(
    std::vector<CObservationClassedBearingRange::Detection> detections) {
  CObservationClassedBearingRange o;
  o.timestamp = mrpt::Clock::fromDouble(100);
  o.sensorLabel = "D";
  o.std_range = 0.5F;
  o.std_yaw = 0.25F;
  o.std_pitch = 0.125F;
  o.class_names = {"a", "b"};
  o.detections = std::move(detections);
  return o;
}

TEST(Detections, ClassedObservationCarriesOver) {
  auto o = classed({{3, 0.5F, -0.25F, 4, 5, {0.25F, 0.75F}}, {2, 4, 0, -1, -1, {}}});
  o.sensor_pose = {1, 2, 3, 0, 0, 0};
  DropReport report;
  const auto frame = detections_in(o, {}, report);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(report.empty());
  EXPECT_EQ(frame->time, 100);
  EXPECT_EQ(frame->sensor_label, "D");
  EXPECT_EQ(frame->T_robot_sensor.translation().z(), 3);
  EXPECT_TRUE(frame->is_3d);
  ASSERT_EQ(frame->detections.size(), 2U);
  const Detection& d = frame->detections[0];
  EXPECT_EQ(d.range, 3);
  EXPECT_EQ(d.yaw, 0.5);
  EXPECT_EQ(d.pitch, -0.25);
  EXPECT_EQ(d.id, 4);
  EXPECT_EQ(d.true_id, 5);
  EXPECT_EQ(d.class_probabilities, (std::vector<double>{0.25, 0.75}));
  EXPECT_TRUE(
      d.covariance.isApprox(Eigen::Matrix3d(Eigen::Vector3d(0.25, 0.0625, 0.015625).asDiagonal())));
  EXPECT_FALSE(frame->detections[1].id);
  EXPECT_FALSE(frame->detections[1].true_id);
  EXPECT_NEAR(frame->detections[1].yaw, 4 - 2 * M_PI, 1e-6);

  o.has_pitch = false;
  const auto planar = detections_in(o, {}, report);
  EXPECT_FALSE(planar->is_3d);
  EXPECT_EQ(planar->detections[0].pitch, 0);
  EXPECT_EQ(planar->detections[0].covariance(2, 2), 0);
}

TEST(Detections, BadMeasurementsAreDroppedAndCounted) {
  const std::vector<std::pair<CObservationClassedBearingRange::Detection, std::string>> cases{
      {{kNaN, 0, 0, 1, 1, {}}, "detection dropped: range not finite"},
      {{kInf, 0, 0, 1, 1, {}}, "detection dropped: range not finite"},
      {{0, 0, 0, 1, 1, {}}, "detection dropped: range not positive"},
      {{-2, 0, 0, 1, 1, {}}, "detection dropped: range not positive"},
      {{2000, 0, 0, 1, 1, {}}, "detection dropped: range above limit"},
      {{1, kNaN, 0, 1, 1, {}}, "detection dropped: yaw not finite"},
      {{1, 50, 0, 1, 1, {}}, "detection dropped: yaw absurd"},
      {{1, 0, kInf, 1, 1, {}}, "detection dropped: pitch not finite"},
      {{1, 0, 1.7F, 1, 1, {}}, "detection dropped: pitch absurd"}};
  for (const auto& [bad, reason] : cases) {
    DropReport report;
    const auto frame = detections_in(classed({{1, 0, 0, 7, 7, {}}, bad}), {}, report);
    EXPECT_EQ(frame->detections.size(), 1U) << reason;
    EXPECT_EQ(report, (DropReport{{reason, 1}}));
  }
  DropReport report;
  const auto frame = detections_in(
      classed(
          {{1, 0, 0, 7, 7, {}}, {2, 0, 0, 7, 7, {}}, {3, 0, 0, -1, 7, {}}, {4, 0, 0, -1, 7, {}}}),
      {}, report);
  EXPECT_EQ(frame->detections.size(), 3U);
  EXPECT_EQ(frame->detections[0].range, 1);
  EXPECT_EQ(report, (DropReport{{"detection dropped: id twice in one observation", 1}}));
}

TEST(Detections, ClassScoresAreRemovedOrNormalised) {
  const std::vector<std::tuple<std::vector<float>, std::string, std::vector<double>>> cases{
      {{1}, "class scores removed: wrong length", {}},
      {{-0.5F, 1.5F}, "class scores removed: negative or not finite", {}},
      {{kNaN, 1}, "class scores removed: negative or not finite", {}},
      {{0, 0}, "class scores removed: all zero", {}},
      {{1, 3}, "class scores repaired: normalised", {0.25, 0.75}}};
  for (const auto& [scores, reason, expected] : cases) {
    DropReport report;
    const auto frame = detections_in(classed({{1, 0, 0, 7, 7, scores}}), {}, report);
    ASSERT_EQ(frame->detections.size(), 1U) << reason;
    EXPECT_EQ(frame->detections[0].class_probabilities, expected);
    EXPECT_EQ(report, (DropReport{{reason, 1}}));
  }
}

TEST(Detections, SigmasOverriddenOrDefaulted) {
  auto o = classed({{1, 0, 0, 7, 7, {}}});
  o.std_range = 0;
  o.std_yaw = kNaN;
  DetectionOptions options;
  options.sigma_pitch = 0.5;
  DropReport report;
  const auto frame = detections_in(o, options, report);
  EXPECT_TRUE(frame->detections[0].covariance.isApprox(
      Eigen::Matrix3d(Eigen::Vector3d(0.01, 0.0004, 0.25).asDiagonal())));
  EXPECT_EQ(report, (DropReport{{"sigma repaired: not positive, default taken", 2}}));
}

TEST(Detections, PlainObservationWithOwnCovariances) {
  mrpt::obs::CObservationBearingRange o;
  o.timestamp = INVALID_TIMESTAMP;
  o.validCovariances = true;
  mrpt::math::CMatrixDouble33 good, bad;
  good.setDiagonal(3, 0.5);
  bad.setZero();
  good(0, 1) = good(1, 0) = 0.1;
  o.sensedData.push_back({2, 0.5F, 0, 1, good});
  o.sensedData.push_back({2, 0.5F, 0, 2, bad});
  o.sensedData.push_back({2, 0.5F, 0, -7, good});
  DropReport report;
  const auto frame = detections_in(o, {}, report);
  ASSERT_EQ(frame->detections.size(), 2U);
  EXPECT_TRUE(frame->is_3d);
  EXPECT_EQ(frame->time, 0);
  EXPECT_TRUE(frame->detections[0].covariance.isApprox(Eigen::Matrix3d(good.asEigen())));
  EXPECT_FALSE(frame->detections[1].id);
  EXPECT_EQ(report, (DropReport{{"detection dropped: covariance not positive definite", 1},
                                {"id repaired: negative, taken as none", 1}}));
}

TEST(Detections, PlainObservationIsPlanarWithoutPitch) {
  mrpt::obs::CObservationBearingRange o;
  o.sensor_std_range = 0.5F;
  o.sensor_std_yaw = 0.5F;
  o.sensedData.push_back({2, 0.5F, 0, 1, {}});
  DropReport report;
  EXPECT_FALSE(detections_in(o, {}, report)->is_3d);
  o.sensor_std_pitch = 0.1F;
  EXPECT_TRUE(detections_in(o, {}, report)->is_3d);
  EXPECT_TRUE(report.empty());
}

TEST(Detections, OtherClassesAndBadSensorPoses) {
  DropReport report;
  EXPECT_FALSE(detections_in(mrpt::obs::CObservationOdometry(), {}, report));
  EXPECT_TRUE(report.empty());
  auto o = classed({{1, 0, 0, 7, 7, {}}});
  o.sensor_pose.x(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(detections_in(o, {}, report));
  EXPECT_EQ(report, (DropReport{{"observation dropped: sensor pose not finite", 1}}));
}

TEST(Detections, SensorPosesThatCannotBe) {
  auto far = classed({{1, 0, 0, 7, 7, {}}}), sheared = far;
  far.sensor_pose = {0, 2000, 0, 0, 0, 0};
  mrpt::math::CMatrixDouble33 R;
  R.setIdentity();
  R(0, 1) = 0.01;
  sheared.sensor_pose.setRotationMatrix(R);
  for (const auto& o : {far, sheared}) {
    DropReport report;
    EXPECT_FALSE(detections_in(o, {}, report));
    EXPECT_EQ(report, (DropReport{{"observation dropped: sensor pose absurd", 1}}));
  }
}

TEST(Detections, BeyondTheLimitOfTheSensor) {
  auto o = classed({{12, 0, 0, 1, 1, {}}, {13, 0, 0, 2, 2, {}}, {40, 0, 0, 3, 3, {}}});
  o.max_range = 10;  // and a sigma of 0.5
  DropReport report;
  EXPECT_EQ(detections_in(o, {}, report)->detections.size(), 1U);
  EXPECT_EQ(report, (DropReport{{"detection dropped: range above that of the sensor", 2}}));
  for (const float no_limit : {0.0F, -1.0F, kNaN, kInf}) {
    o.max_range = no_limit;
    EXPECT_EQ(detections_in(o, {}, report)->detections.size(), 3U) << no_limit;
  }
  o.has_range = false;
  o.max_range = 10;
  EXPECT_EQ(detections_in(o, {}, report)->detections.size(), 3U);
}

TEST(Detections, SigmasThatCannotBe) {
  // Nothing is told by a range that may be anything, or a direction that may be any.
  for (const auto& [range, yaw, pitch] :
       {std::tuple{1e7F, 0.1F, 0.1F}, {0.1F, 4.0F, 0.1F}, {0.1F, 0.1F, 1e20F}}) {
    DropReport report;
    const auto frame = detections_in(
        classed({{1, 0, 0, 1, 1, {}, range, yaw, pitch}, {1, 1, 0, 2, 2, {}}}), {}, report);
    EXPECT_EQ(frame->detections.size(), 1U);
    EXPECT_EQ(report, (DropReport{{"detection dropped: sigma absurd", 1}}));
  }
  // Too small to be true: the noise of the sensor, or the default, counts.
  auto o = classed({{1, 0, 0, 1, 1, {}, 1e-30F, 1e-7F, 0}});
  o.std_pitch = 1e-20F;
  DropReport report;
  EXPECT_TRUE(detections_in(o, {}, report)
                  ->detections.at(0)
                  .covariance.isApprox(
                      Eigen::Matrix3d(Eigen::Vector3d(0.25, 0.0625, 0.0004).asDiagonal())));
  EXPECT_EQ(report, (DropReport{{"sigma repaired: not positive, default taken", 1}}));

  mrpt::obs::CObservationBearingRange own;
  own.validCovariances = true;
  mrpt::math::CMatrixDouble33 tiny;
  tiny.setDiagonal(3, 1e-40);
  own.sensedData.push_back({2, 0.5F, 0.1F, 2, tiny});
  report.clear();
  EXPECT_TRUE(detections_in(own, {}, report)->detections.empty());
  EXPECT_EQ(report, (DropReport{{"detection dropped: covariance not positive definite", 1}}));
}

TEST(Detections, IdsAsAskedFor) {
  auto o = classed({{3, 0, 0, 4, -1, {}}, {3, 0.1F, 0, -1, 6, {}}, {3, 0.2F, 0, 4, -1, {}}});
  DetectionOptions options;
  DropReport report;
  options.ids = IdSource::kNone;
  auto frame = detections_in(o, options, report);
  ASSERT_EQ(frame->detections.size(), 3U);  // without ids, none is there twice
  for (const Detection& d : frame->detections) EXPECT_FALSE(d.id);
  EXPECT_EQ(frame->detections[0].true_id, 4);
  options.ids = IdSource::kTruth;
  frame = detections_in(o, options, report);
  ASSERT_EQ(frame->detections.size(), 2U);
  EXPECT_EQ(frame->detections[1].id, 6);
}

TEST(Detections, SigmasOfTheirOwn) {
  auto o = classed({{3, 0, 0, -1, -1, {}, 2.0F, 0, 0.5F}});
  DropReport report;
  DetectionOptions options;
  const auto variances = [&] {
    return Eigen::Vector3d(
        detections_in(o, options, report)->detections.at(0).covariance.diagonal());
  };
  EXPECT_TRUE(variances().isApprox(Eigen::Vector3d(4, 0.0625, 0.25)));
  options.sigma_range = 1;  // what is chosen counts for all
  EXPECT_TRUE(variances().isApprox(Eigen::Vector3d(1, 0.0625, 0.25)));
}

TEST(Detections, BehindTheSensorAndWithoutRange) {
  auto o = classed({{3, 0.9F, 0, -1, -1, {}}, {3, 3.1F, 0, -1, -1, {}}});
  o.fov_yaw = 2;
  o.std_yaw = 0.01F;
  DropReport report;
  EXPECT_EQ(detections_in(o, {}, report)->detections.size(), 1U);
  EXPECT_EQ(report, (DropReport{{"detection dropped: outside the field of view", 1}}));

  o = classed({{NAN, 0.9F, 0, -1, -1, {}}, {0, NAN, 0, -1, -1, {}}});
  o.has_range = false;
  o.std_range = 0;
  report.clear();
  const auto frame = detections_in(o, {}, report);
  EXPECT_FALSE(frame->has_range);
  ASSERT_EQ(frame->detections.size(), 1U);
  EXPECT_EQ(frame->detections[0].range, 0);
  EXPECT_EQ(report, (DropReport{{"detection dropped: yaw not finite", 1}}));
}

}  // namespace
}  // namespace hybrid
