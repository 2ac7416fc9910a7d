// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/methods/robust_methods.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "libhybrid/core/error.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

RobustTask task_of(const testing::CorruptedGraph& g) {
  RobustTask task;
  task.problem = g.problem;
  task.truth = g.truth;
  return task;
}

TEST(RobustMethods, NamesAreUnique) {
  std::set<std::string> names;
  for (const RobustMethod& method : robust_methods()) {
    EXPECT_FALSE(method.meaning.empty()) << method.name;
    EXPECT_TRUE(names.insert(method.name).second) << method.name;
    if (method.old_name.empty()) continue;
    EXPECT_TRUE(names.insert(method.old_name).second) << method.old_name;
  }
}

TEST(RobustMethods, OldNamesAreStillUnderstood) {
  EXPECT_EQ(robust_method("escape").name, "selection");
  EXPECT_EQ(robust_method("consistency-escape").name, "consistency-selection");
  EXPECT_EQ(robust_method("gnc").name, "gnc");
  for (const char* unknown : {"", "escap", "Selection"}) {
    EXPECT_THROW(robust_method(unknown), Error) << unknown;
  }
}

TEST(RobustMethods, EachSolvesWithTheOptionsAsTheyAre) {
  const auto g = testing::drive_laps<SE2>(3, 6, 1);
  for (const RobustMethod& method : robust_methods()) {
    if (method.name == "online") continue;
    MethodOptions options;
    options.set_threads(1);
    const RobustResult result = method.solve(task_of(g), options);
    EXPECT_EQ(result.decisions.size(), g.problem.closures.size()) << method.name;
    EXPECT_TRUE(std::isfinite(result.objective)) << method.name;
    EXPECT_EQ(result.members.empty(), method.name != "portfolio") << method.name;
  }
}

TEST(RobustMethods, OracleAndOdometryTakeWhatTheyAreTold) {
  const auto g = testing::drive_laps<SE2>(3, 6, 1);
  const auto accepted = [&](const char* name) {
    std::vector<bool> in;
    for (const ClosureDecision& v : robust_method(name).solve(task_of(g), {}).decisions) {
      in.push_back(v.accepted());
    }
    return in;
  };
  EXPECT_EQ(accepted("oracle"), g.truth);
  EXPECT_EQ(accepted("odometry"), std::vector<bool>(g.truth.size(), false));
  EXPECT_EQ(accepted("lm"), std::vector<bool>(g.truth.size(), true));
}

TEST(RobustMethods, WhatIsMissingIsAnError) {
  const auto g = testing::drive_laps<SE2>(2, 1, 1);
  RobustTask task = task_of(g);
  task.truth.clear();
  EXPECT_THROW(robust_method("oracle").solve(task, {}), Error);
  EXPECT_THROW(robust_method("online").solve(task, {}), Error);
}

// A gate that no closure passes leaves all out, whichever way the method selects.
TEST(RobustMethods, SettingsOfSelectionReachEveryMethodThatSelects) {
  const auto g = testing::drive_laps<SE2>(3, 0, 1);
  MethodOptions options;
  options.portfolio.selection.gate = 1e-12;
  for (const char* name : {"selection", "consistency-selection"}) {
    for (const ClosureDecision& v : robust_method(name).solve(task_of(g), options).decisions) {
      EXPECT_FALSE(v.accepted()) << name;
    }
  }
}

TEST(RobustMethods, EachRefusesAMixtureThatIsNone) {
  const auto g = testing::drive_laps<SE2>(3, 6, 1);
  for (const double wrong : {std::nan(""), -1.0}) {
    MixtureOptions mixture;
    mixture.inlier_weight = wrong;
    MethodOptions options;
    options.set_mixture(mixture);
    for (const RobustMethod& method : robust_methods()) {
      if (method.name == "online") continue;
      EXPECT_THROW(method.solve(task_of(g), options), SettingsError) << method.name;
    }
    OnlineSelection online(options.online);
    Delta delta;
    delta.values = g.problem.initial;
    delta.continuous = g.problem.trusted;
    EXPECT_THROW(online.update(delta, g.problem.closures), SettingsError);
    EXPECT_THROW(online.status(0), Error);
  }
}

TEST(RobustMethods, OneMixtureForAll) {
  MethodOptions options;
  MixtureOptions mixture;
  mixture.inlier_weight = 0.25;
  options.set_mixture(mixture);
  for (const MixtureOptions* each :
       {&options.common.mixture, &options.gnc.mixture, &options.dcs.mixture,
        &options.switchable.mixture, &options.alternation.mixture,
        &options.portfolio.selection.mixture, &options.online.mixture,
        &options.online.selection.mixture}) {
    EXPECT_EQ(each->inlier_weight, 0.25);
    EXPECT_EQ(each->flat, each == &options.online.mixture);
  }
}

}  // namespace
}  // namespace hybrid
