// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/read_landmark_options.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

ClassModel model(const std::string& keys) {
  IniFile ini("[classes]\n" + keys, "test.ini");
  IniSection section = ini.section("classes");
  return read_class_model(section);
}

/// What is said of keys that do not fit each other; empty where they do.
std::string refusal(const std::string& keys) {
  try {
    model(keys);
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(ReadLandmarkOptions, ClassesAreAsTheFileSays) {
  const ClassModel classes = model(
      "class_names = tree car\nclass_prior = 0.2 0.8\nconfusion = 0.9 0.1 0.4 0.6\n"
      "score_floor = 1e-12\n");
  EXPECT_EQ(classes.names(), (std::vector<std::string>{"tree", "car"}));
  EXPECT_EQ(classes.prior(), (std::vector<double>{0.2, 0.8}));
  EXPECT_NEAR(classes.likelihood({1, 0}, {"tree", "car"})[1], 0.4, 1e-9);
}

TEST(ReadLandmarkOptions, AClassThatDoesNotFitIsNamedWithFileAndLine) {
  const std::string two = "class_names = a b\n";
  for (const auto& [keys, key] : std::vector<std::pair<std::string, std::string>>{
           {"\nclass_prior = 0.5 0.5\n", "class_names"},
           {two + "class_prior = 1\n", "class_prior"},
           {two + "class_prior = 0 0\n", "class_prior"},
           {two + "confusion = 1 0 0\n", "confusion"},
           {two + "confusion = 1 0 0.4 0.4\n", "confusion"}}) {
    const std::string message = refusal(keys);
    EXPECT_NE(message.find(key), std::string::npos) << message;
    EXPECT_NE(message.find("test.ini"), std::string::npos) << message;
  }
  EXPECT_NE(refusal(two + "confusion = 1 0 0\n").find("test.ini:3"), std::string::npos);
  EXPECT_EQ(refusal(two), "");
}

TEST(ReadLandmarkOptions, AnEmptySectionGivesTheDefaultsOfTheLibrary) {
  IniFile ini("", "test.ini");
  IniSection section = ini.section("association");
  const AssociationOptions read = read_association_options(section), own;
  EXPECT_EQ(read.method, own.method);
  EXPECT_EQ(read.use_ids, own.use_ids);
  EXPECT_EQ(read.gate, own.gate);
  EXPECT_EQ(read.information_penalty, own.information_penalty);
  EXPECT_EQ(read.hypotheses, own.hypotheses);
  EXPECT_EQ(read.keep_open_odds, own.keep_open_odds);
  EXPECT_EQ(read.old_landmark_odds, own.old_landmark_odds);
  EXPECT_EQ(read.clutter_odds, own.clutter_odds);
  EXPECT_EQ(read.window, own.window);
  EXPECT_EQ(read.landmarks_in_view, own.landmarks_in_view);
  EXPECT_EQ(read.clutter_in_view, own.clutter_in_view);
  EXPECT_EQ(read.detection_probability, own.detection_probability);
  EXPECT_EQ(read.confirm, own.confirm);
  EXPECT_EQ(read.merge, own.merge);
  EXPECT_EQ(read.recent, own.recent);
  EXPECT_EQ(read.merge_odds, own.merge_odds);
}

TEST(ReadLandmarkOptions, EveryKeyIsRead) {
  IniFile ini(
      "[a]\nmethod = jcbb\nuse_ids = no\ngate = 0.9\ncaution = 2\nhypotheses = 3\nkeep_open_odds = "
      "4\n"
      "old_landmark_odds = 12\nclutter_odds = 13\n"
      "window = 5\nlandmarks_in_view = 6\nclutter_in_view = 7\ndetection_probability = 0.8\n"
      "confirm = 9\nmerge = no\nrecent = 10\nmerge_odds = 11\n",
      "test.ini");
  IniSection section = ini.section("a");
  const AssociationOptions o = read_association_options(section);
  EXPECT_EQ(o.method, AssociationOptions::Method::kJcbb);
  EXPECT_FALSE(o.use_ids || o.merge);
  EXPECT_EQ(o.gate, 0.9);
  EXPECT_EQ(o.information_penalty, 2);
  EXPECT_EQ(o.hypotheses, 3);
  EXPECT_EQ(o.keep_open_odds, 4);
  EXPECT_EQ(o.old_landmark_odds, 12);
  EXPECT_EQ(o.clutter_odds, 13);
  EXPECT_EQ(o.window, 5);
  EXPECT_EQ(o.landmarks_in_view, 6);
  EXPECT_EQ(o.clutter_in_view, 7);
  EXPECT_EQ(o.detection_probability, 0.8);
  EXPECT_EQ(o.confirm, 9);
  EXPECT_EQ(o.recent, 10);
  EXPECT_EQ(o.merge_odds, 11);
}

TEST(ReadLandmarkOptions, AKeyThatHadSeveralMeaningsKeepsThemAll) {
  IniFile ini("[a]\nopen_odds = 4\n[b]\nopen_odds = 4\nclutter_odds = 5\n[c]\nopen_odds = 4\n",
              "test.ini");
  IniSection section = ini.section("a");
  const AssociationOptions o = read_association_options(section);
  EXPECT_EQ(o.keep_open_odds, 4);
  EXPECT_EQ(o.old_landmark_odds, 4);
  EXPECT_EQ(o.clutter_odds, 4);
  const std::vector<std::string> warnings = ini.warnings();
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_NE(warnings[0].find("keep_open_odds, old_landmark_odds, clutter_odds"), std::string::npos);
  IniSection twice = ini.section("b");
  EXPECT_THROW(read_association_options(twice), Error);
  ini.override_value("c", "clutter_odds", "6");
  IniSection overridden = ini.section("c");
  const AssociationOptions c = read_association_options(overridden);
  EXPECT_EQ(c.old_landmark_odds, 4);
  EXPECT_EQ(c.clutter_odds, 6);
}

}  // namespace
}  // namespace hybrid
