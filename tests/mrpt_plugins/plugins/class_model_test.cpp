// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/class_model.h"

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

ClassModel model(const std::string& keys) {
  IniFile ini("[classes]\n" + keys, "test.ini");
  IniSection section = ini.section("classes");
  return ClassModel(section);
}

TEST(ClassModel, ScoresAreTheLikelihoodOfACalibratedDetector) {
  ClassModel classes = model("score_floor = 1e-12\n");
  classes.learn_names({"tree", "car"});
  const auto phi = classes.likelihood({0.7, 0.3}, {"tree", "car"});
  EXPECT_NEAR(phi[0], 0.7, 1e-9);
  EXPECT_NEAR(phi[1], 0.3, 1e-9);
  EXPECT_EQ(classes.prior(), std::vector<double>({0.5, 0.5}));
}

TEST(ClassModel, ConfusionMatrixGivesItsColumn) {
  const ClassModel classes =
      model("class_names = tree car\nconfusion = 0.9 0.1 0.4 0.6\nscore_floor = 1e-12\n");
  const auto phi = classes.likelihood({1, 0}, {"tree", "car"});  // detected: tree
  EXPECT_NEAR(phi[0], 0.9, 1e-9);
  EXPECT_NEAR(phi[1], 0.4, 1e-9);
}

TEST(ClassModel, NamesOfTheLogMayComeInAnotherOrder) {
  const ClassModel classes = model("class_names = tree car\n");
  const auto phi = classes.likelihood({0.2, 0.8}, {"car", "tree"});
  EXPECT_NEAR(phi[0], 0.8, 1e-5);
  EXPECT_THROW(classes.likelihood({1.0}, {"dog"}), Error);
}

TEST(ClassModel, FloorKeepsEveryClassPossible) {
  const ClassModel classes = model("class_names = a b\nscore_floor = 0.1\n");
  const auto phi = classes.likelihood({1, 0}, {"a", "b"});
  EXPECT_NEAR(phi[0], 0.95, 1e-12);
  EXPECT_NEAR(phi[1], 0.05, 1e-12);
}

TEST(ClassModel, DetectionWithoutScoresSaysNothing) {
  const ClassModel classes = model("class_names = a b c\n");
  EXPECT_EQ(classes.likelihood({}, {}), std::vector<double>({1, 1, 1}));
}

TEST(ClassModel, RejectsWhatDoesNotFit) {
  EXPECT_THROW(model("class_prior = 0.5 0.5\n"), Error);
  EXPECT_THROW(model("class_names = a b\nclass_prior = 1\n"), Error);
  EXPECT_THROW(model("class_names = a b\nclass_prior = 0 0\n"), Error);
  EXPECT_THROW(model("class_names = a b\nconfusion = 1 0 0\n"), Error);
  EXPECT_THROW(model("class_names = a b\nconfusion = 1 0 0.4 0.4\n"), Error);
  ClassModel nameless = model("");
  EXPECT_THROW(nameless.learn_names({}), Error);
}

}  // namespace
}  // namespace hybrid
