// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace hybrid {
namespace {

constexpr double kEquatorial = 6378137.0;  // semi-axes of WGS84 [m]
constexpr double kPolar = 6356752.314245179;
constexpr double kNanometres = 2e-8;  // [m]; a double of 1e7 m has steps of 2e-9

void expect_near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance) {
  EXPECT_LT((a - b).norm(), tolerance) << a.transpose() << " and " << b.transpose();
}

/// Places whose coordinates are easily got wrong.
std::vector<GeodeticPoint> odd_places() {
  std::vector<GeodeticPoint> places;
  for (const double latitude : {-90.0, -89.9999999, -33.885, -1e-9, 0.0, 47.0, 89.0, 90.0}) {
    for (const double longitude : {-180.0, -179.9999999, -90.0, 0.0, 151.19, 180.0}) {
      for (const double altitude : {-400.0, 0.0, 8848.0, 1e7}) {
        places.push_back({latitude, longitude, altitude});
      }
    }
  }
  return places;
}

TEST(Geodesy, AxesOfTheEllipsoid) {
  expect_near(ecef_of({0, 0, 0}), {kEquatorial, 0, 0}, 1e-9);
  expect_near(ecef_of({0, 90, 10}), {0, kEquatorial + 10, 0}, 1e-9);
  expect_near(ecef_of({0, 180, 0}), {-kEquatorial, 0, 0}, 1e-9);
  expect_near(ecef_of({90, 12, 5}), {0, 0, kPolar + 5}, 1e-8);
  expect_near(ecef_of({-90, 0, 0}), {0, 0, -kPolar}, 1e-8);
}

TEST(Geodesy, KnownPlace) {
  // By the closed formula x = (N + h) cos(lat) cos(lon), ..., z = (N (1 - e^2) + h) sin(lat).
  const GeodeticPoint sydney{-33.885, 151.190, 30};
  const double f = 1 / 298.257223563, e2 = f * (2 - f);
  const double lat = sydney.latitude * M_PI / 180, lon = sydney.longitude * M_PI / 180;
  const double n = kEquatorial / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  expect_near(ecef_of(sydney),
              {(n + 30) * std::cos(lat) * std::cos(lon), (n + 30) * std::cos(lat) * std::sin(lon),
               (n * (1 - e2) + 30) * std::sin(lat)},
              kNanometres);
}

TEST(Geodesy, RoundTripOfEcef) {
  for (const GeodeticPoint& place : odd_places()) {
    const Eigen::Vector3d ecef = ecef_of(place);
    const GeodeticPoint back = geodetic_of(ecef);
    expect_near(ecef_of(back), ecef, kNanometres);
    EXPECT_NEAR(back.altitude, place.altitude, kNanometres);
    EXPECT_NEAR(back.latitude, place.latitude, 1e-12);
    EXPECT_LE(std::abs(back.longitude), 180);
  }
}

TEST(Geodesy, RoundTripOfLocalFrames) {
  for (const GeodeticPoint& datum : odd_places()) {
    const LocalFrame frame(datum);
    expect_near(frame.to_local(datum), {0, 0, 0}, 1e-8);
    for (const Eigen::Vector3d& local :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, -20, 3), Eigen::Vector3d(-1e5, 1e5, 50)}) {
      expect_near(frame.to_local(frame.to_geodetic(local)), local, 3 * kNanometres);
    }
  }
}

TEST(Geodesy, LocalAxes) {
  const LocalFrame frame({-33.885, 151.190, 0});
  const double step = 1e-5;  // about a metre
  const Eigen::Vector3d north = frame.to_local({-33.885 + step, 151.190, 0});
  const Eigen::Vector3d east = frame.to_local({-33.885, 151.190 + step, 0});
  expect_near(frame.to_local({-33.885, 151.190, 2}), {0, 0, 2}, 1e-8);
  expect_near(north, {0, 1.10917, 0}, 1e-4);
  expect_near(east, {0.92508, 0, 0}, 1e-4);
}

TEST(Geodesy, LocalFrameAcrossTheDateLine) {
  const LocalFrame frame({10, 179.99999, 0});
  const Eigen::Vector3d across = frame.to_local({10, -179.99999, 0});
  EXPECT_NEAR(across.x(), 2.193, 1e-3);
  EXPECT_NEAR(across.y(), 0, 1e-6);
  EXPECT_LT(frame.to_geodetic(across).longitude, 0);
}

TEST(Geodesy, WhatIsNoPlaceIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(ecef_of({nan, 0, 0}).x()));
  EXPECT_TRUE(std::isnan(ecef_of({91, 0, 0}).x()));
  EXPECT_TRUE(std::isnan(ecef_of({0, std::numeric_limits<double>::infinity(), 0}).x()));
  EXPECT_TRUE(std::isnan(geodetic_of({nan, 0, 0}).altitude));
}

}  // namespace
}  // namespace hybrid
