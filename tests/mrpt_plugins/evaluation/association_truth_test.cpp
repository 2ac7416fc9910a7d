// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/association_truth.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

AssociationTruth read(const std::string& text) {
  const TemporaryFile file("associations.csv");
  std::ofstream(file.path()) << text;
  return read_true_associations(file.path());
}

TEST(AssociationTruth, IsKeyedByStepAndMeasurement) {
  const AssociationTruth truth = read("step,measurement,true_id\n0,0,4\n0,1,2\n7,0,4\n");
  ASSERT_EQ(truth.size(), 3U);
  EXPECT_EQ(truth.at({0, 1}), 2);
  EXPECT_EQ(truth.at({7, 0}), 4);
  EXPECT_EQ(read("3,1,5\n").at({3, 1}), 5);  // without names of columns
}

TEST(AssociationTruth, BadFilesAreErrorsThatNameTheLine) {
  for (const char* text : {"step,measurement,true_id\n0,0\n", "0,0,x\n", "0,0,1\n0,0,2\n", ""}) {
    EXPECT_THROW(read(text), Error) << text;
  }
  EXPECT_THROW(read_true_associations("/no/such/file.csv"), Error);
}

}  // namespace
}  // namespace hybrid
