// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mover_writer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace hybrid {
namespace {

TEST(MoversCsv, HasALineForEachStateWithAllColumns) {
  MapResult result;
  result.class_names = {"car", "a \"van\", white"};
  MoverEstimate mover;
  mover.id = 4;
  mover.probability = 0.75;
  mover.class_index = 1;
  mover.sightings = 3;
  mover.states.resize(2);
  mover.keyframes = {6, 8};
  mover.states[1].time = 12.5;
  mover.states[1].position = {1, 2, 0};
  mover.states[1].velocity = {-3, 0.5, 0};
  mover.states[1].covariance.diagonal() << 0.01, 0.02, 0, 0.1, 0.2, 0;
  mover.states[1].covariance(3, 4) = 0.05;
  result.movers = {mover};
  std::istringstream text(movers_csv(result));
  std::string heading, first, second, more;
  std::getline(text, heading);
  std::getline(text, first);
  std::getline(text, second);
  EXPECT_FALSE(std::getline(text, more));
  EXPECT_EQ(second,
            "4,0.75,\"a \"\"van\"\", white\",3,8,12.5,1,2,0,-3,0.5,0,"
            "0.01,0,0,0.02,0,0,0.1,0.05,0,0.2,0,0");
  EXPECT_EQ(std::count(heading.begin(), heading.end(), ','), 23);
  EXPECT_EQ(std::count(first.begin(), first.end(), ','), 24);  // one in the name
}

}  // namespace
}  // namespace hybrid
