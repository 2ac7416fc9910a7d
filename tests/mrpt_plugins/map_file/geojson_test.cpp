// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mrpt_plugins/map_file/export_map.h"

namespace hybrid {
namespace {

/// Degrees by the radii of curvature of the ellipsoid of WGS 84 at a place; they hold for some
/// hundred metres about it.
Eigen::Vector2d longitude_and_latitude(const GeodeticPoint& at, const Eigen::Vector3d& east_north) {
  constexpr double kRadius = 6378137, kSquaredEccentricity = 6.69437999014e-3;
  const double sine = std::sin(at.latitude * M_PI / 180);
  const double w = 1 - kSquaredEccentricity * sine * sine;
  const double prime_vertical = kRadius / std::sqrt(w);
  const double meridian = prime_vertical * (1 - kSquaredEccentricity) / w;
  const double of_parallel = (prime_vertical + at.altitude) * std::sqrt(1 - sine * sine);
  const Eigen::Vector2d turned(east_north.x() / of_parallel,
                               east_north.y() / (meridian + at.altitude));
  return Eigen::Vector2d(at.longitude, at.latitude) + turned * 180 / M_PI;
}

TEST(GeoJson, PutsAMapWhereItsDatumIs) {
  MapResult result;
  result.datum = MapDatum();
  result.datum->origin = {36.7, -4.5, 400};
  result.datum->T_datum_map =
      Eigen::Translation3d(120, -40, 3) * Eigen::AngleAxisd(-2, Eigen::Vector3d::UnitZ());
  FixEstimate fix;
  fix.measured = {90, 60, 0};
  fix.mode = FixMode::kFalse;
  fix.probabilities = {0.1, 0.2, 0.7};
  result.fixes = {fix};
  LandmarkEstimate landmark;
  landmark.id = 7;
  landmark.position = {-50, 30, 0};
  result.landmarks = {landmark};
  result.trajectory = {{0, {}}, {1, mrpt::poses::CPose3D(10, 0, 0)}};
  const auto json = nlohmann::json::parse(geojson_text(result, origin_of(*result.datum)));
  EXPECT_EQ(json["type"], "FeatureCollection");
  EXPECT_EQ(json["crs_name"], "OGC:CRS84");
  ASSERT_EQ(json["features"].size(), 3U);
  const auto expect_at = [&](const nlohmann::json& coordinates, const Eigen::Vector3d& in_map) {
    const Eigen::Vector2d expected =
        longitude_and_latitude(result.datum->origin, result.datum->T_datum_map * in_map);
    EXPECT_NEAR(coordinates[0], expected.x(), 5e-8);  // 5 mm
    EXPECT_NEAR(coordinates[1], expected.y(), 5e-8);
  };
  const auto of = [&](std::size_t i) { return json["features"][i]["geometry"]["coordinates"]; };
  expect_at(of(0), landmark.position);
  expect_at(of(1)[1], {10, 0, 0});
  expect_at(of(2), fix.measured);
  EXPECT_EQ(json["features"][2]["properties"]["fix"], "false");
  EXPECT_EQ(json["features"][2]["properties"]["p_false"], 0.7);
}

}  // namespace
}  // namespace hybrid
