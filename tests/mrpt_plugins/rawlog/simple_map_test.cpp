// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>

#include <variant>
#include <vector>

#include "mrpt_plugins/rawlog/object_reader.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

std::vector<LogObject> objects_of(const std::string& path, LogStatus status) {
  ObjectReader reader(path);
  std::vector<LogObject> out;
  while (auto object = reader.next()) out.push_back(std::move(*object));
  EXPECT_EQ(reader.status(), status) << reader.message();
  return out;
}

TEST(SimpleMap, IsALogOfItsKeyframes) {
  mrpt::maps::CSimpleMap map;
  for (int i = 0; i < 3; ++i) {
    auto seen = mrpt::obs::CSensoryFrame::Create();
    seen->insert(observation(i));
    auto pose = mrpt::poses::CPose3DPDFGaussian::Create();
    pose->mean = mrpt::poses::CPose3D(2.0 * i, 1, 0.5 * i, 0.1 * i, 0, 0);
    map.insert(mrpt::poses::CPose3DPDF::Ptr(pose), seen);
  }
  const TemporaryFile file("keyframes.simplemap");
  ASSERT_TRUE(map.saveToFile(file.path()));
  const std::vector<LogObject> objects = objects_of(file.path(), LogStatus::kComplete);
  ASSERT_EQ(objects.size(), 5U);
  for (const std::size_t i : {0, 2, 4}) {
    const auto* frame = std::get_if<LoggedFrame>(&objects[i]);
    ASSERT_NE(frame, nullptr) << i;
    EXPECT_EQ(frame->observations.size(), 1U);
  }
  const auto* actions = std::get_if<LoggedActions>(&objects[3]);
  ASSERT_NE(actions, nullptr);
  const auto* motion = std::get_if<mrpt::poses::CPose3DPDFGaussian>(&actions->motion);
  ASSERT_NE(motion, nullptr);
  EXPECT_NEAR(motion->mean.norm(), std::hypot(2, 0.5), 1e-9);
  EXPECT_NEAR(motion->mean.yaw(), 0.1, 1e-9);
  EXPECT_GT(motion->cov(0, 0), 1e-4);

  map.clear();
  ASSERT_TRUE(map.saveToFile(file.path()));
  EXPECT_TRUE(objects_of(file.path(), LogStatus::kComplete).empty());
}

}  // namespace
}  // namespace hybrid
