// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/class_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

ClassOptions named(const std::vector<std::string>& names, double floor = 1e-6) {
  ClassOptions options;
  options.names = names;
  options.floor = floor;
  return options;
}

TEST(ClassModel, ScoresAreTheLikelihoodOfACalibratedDetector) {
  ClassModel classes(named({}, 1e-12));
  classes.learn_names({"tree", "car"});
  const auto phi = classes.likelihood({0.7, 0.3}, {"tree", "car"});
  EXPECT_NEAR(phi[0], 0.7, 1e-9);
  EXPECT_NEAR(phi[1], 0.3, 1e-9);
  EXPECT_EQ(classes.prior(), std::vector<double>({0.5, 0.5}));
}

TEST(ClassModel, ConfusionMatrixGivesItsColumn) {
  ClassOptions options = named({"tree", "car"}, 1e-12);
  options.confusion = {0.9, 0.1, 0.4, 0.6};
  const auto phi = ClassModel(options).likelihood({1, 0}, {"tree", "car"});  // detected: tree
  EXPECT_NEAR(phi[0], 0.9, 1e-9);
  EXPECT_NEAR(phi[1], 0.4, 1e-9);
}

TEST(ClassModel, NamesOfTheLogMayComeInAnotherOrder) {
  const ClassModel classes(named({"tree", "car"}));
  const auto phi = classes.likelihood({0.2, 0.8}, {"car", "tree"});
  EXPECT_NEAR(phi[0], 0.8, 1e-5);
  EXPECT_THROW(classes.likelihood({1.0}, {"dog"}), Error);
}

TEST(ClassModel, FloorKeepsEveryClassPossible) {
  const auto phi = ClassModel(named({"a", "b"}, 0.1)).likelihood({1, 0}, {"a", "b"});
  EXPECT_NEAR(phi[0], 0.95, 1e-12);
  EXPECT_NEAR(phi[1], 0.05, 1e-12);
}

TEST(ClassModel, DetectionWithoutScoresSaysNothing) {
  EXPECT_EQ(ClassModel(named({"a", "b", "c"})).likelihood({}, {}), std::vector<double>({1, 1, 1}));
}

TEST(ClassModel, RejectsWhatDoesNotFit) {
  const auto rejects = [](ClassOptions options, std::vector<double> prior,
                          std::vector<double> confusion, const std::string& key) {
    options.prior = std::move(prior);
    options.confusion = std::move(confusion);
    const auto fault = find_fault(options);
    EXPECT_TRUE(fault && fault->key == key) << key;
    EXPECT_THROW(ClassModel model(options), Error);
  };
  const ClassOptions two = named({"a", "b"});
  rejects(named({}), {0.5, 0.5}, {}, "class_names");
  rejects(two, {1}, {}, "class_prior");
  rejects(two, {0, 0}, {}, "class_prior");
  rejects(two, {-0.5, 1.5}, {}, "class_prior");
  rejects(two, {std::nan(""), 1}, {}, "class_prior");
  rejects(two, {}, {1, 0, 0}, "confusion");
  rejects(two, {}, {1, 0, 0.4, 0.4}, "confusion");
  rejects(two, {}, {2, -1, 0.4, 0.6}, "confusion");
  rejects(named({"a", "b"}, 0), {}, {}, "score_floor");
  ClassModel nameless;
  EXPECT_THROW(nameless.learn_names({}), Error);
}

}  // namespace
}  // namespace hybrid
