// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/landmarks/landmark_mapper.h"

namespace hybrid {
namespace {

/// Two keyframes at rest see a thing at each of these places, of these probabilities to be a car.
LandmarkMapper<SE2> mapped(const std::vector<double>& extents, const std::vector<double>& ranges,
                           const std::vector<double>& cars, std::optional<int> id = {}) {
  AssociationOptions options;
  options.extent = extents;
  ClassOptions classes;
  classes.names = {"car", "pole"};
  LandmarkMapper<SE2> mapper(LandmarkAssociation(options, ClassModel(classes)));
  DetectionFrame seen;
  seen.is_3d = false;
  seen.max_range = 30;
  seen.fov_yaw = 2 * M_PI;
  seen.class_names = classes.names;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    Detection d;
    d.range = ranges[i];
    d.covariance.diagonal() << 0.01, 1e-4, 0;
    if (cars[i] >= 0) d.class_probabilities = {cars[i], 1 - cars[i]};
    d.id = id;
    seen.detections.push_back(d);
  }
  const Noise noise = Noise::isotropic(3, 0.01);
  for (int k = 0; k < 2; ++k) mapper.add(SE2(), noise, {seen});
  return mapper;
}

TEST(ClassExtent, IsThatOfWhatADetectionMayBe) {
  const auto sizes = mapped({0.5, 0.1}, {5, 15, 25}, {0.9, 0, -1}).sizes();
  ASSERT_EQ(sizes.size(), 3U);
  EXPECT_NEAR(sizes.at(0).extent, std::sqrt(0.9 * 0.25 + 0.1 * 0.01), 1e-6);
  EXPECT_NEAR(sizes.at(1).extent, 0.1, 1e-4);
  EXPECT_NEAR(sizes.at(2).extent, std::sqrt(0.13), 1e-9);  // it may be either
}

TEST(ClassExtent, OneForAllIsForThoseWithoutClassesToo) {
  for (const auto& [id, size] : mapped({0.3}, {5, 15}, {0.9, -1}).sizes()) {
    EXPECT_EQ(size.extent, 0.3);
  }
}

// A car that is seen a metre off is the same car; a pole is another one.
TEST(ClassExtent, DecidesWhatIsTakenForALandmark) {
  for (const double car : {1.0, 0.0}) {
    LandmarkMapper<SE2> mapper = mapped({1, 0.1}, {10}, {car});
    DetectionFrame off;
    off.is_3d = false;
    off.max_range = 30;
    off.fov_yaw = 2 * M_PI;
    off.class_names = {"car", "pole"};
    Detection d;
    d.range = 11;
    d.covariance.diagonal() << 0.01, 1e-4, 0;
    d.class_probabilities = {car, 1 - car};
    off.detections = {d};
    mapper.add(SE2(), Noise::isotropic(3, 0.01), {off});
    EXPECT_EQ(mapper.landmarks().size(), car == 1 ? 1U : 2U);
  }
}

TEST(ClassExtent, OneForEachClassOrOneForAll) {
  try {
    mapped({1, 2, 3}, {5}, {0.9});
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("extent has 3 numbers for 2 classes"), std::string::npos);
  }
  AssociationOptions none;
  none.extent.clear();
  EXPECT_THROW(LandmarkAssociation{none}, Error);
}

}  // namespace
}  // namespace hybrid
