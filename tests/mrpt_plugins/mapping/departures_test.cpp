// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What plugins and starts have to do with keyframes that leave a bounded window.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid::testing {

/// Changes the map once per keyframe by nothing, as a merge would by much, and notes what that was
/// worth.
class Judge : public MappingPlugin {
  DEFINE_MRPT_OBJECT(Judge, hybrid::testing)

 public:
  void configure(IniSection) override {}
  Contribution observe(const Frame&, const MapView&) override {
    due_ = true;
    return {};
  }
  Contribution revise(const MapView&) override {
    Contribution out;
    judging_ = std::exchange(due_, false);
    if (!judging_) return out;
    out.allowed_rise = allowed;
    out.delta.discrete.emplace_back(std::vector<DiscreteKey>{}, std::vector<double>{1.0});
    return out;
  }
  void applied(const Outcome& outcome) override {
    if (judging_) rises.push_back(outcome.objective_after - outcome.objective_before);
  }
  void refused() override { ++turned_down; }

  double allowed = 1e9;
  std::vector<double> rises;
  int turned_down = 0;

 private:
  bool due_ = false, judging_ = false;
};

}  // namespace hybrid::testing

IMPLEMENTS_MRPT_OBJECT(Judge, hybrid::MappingPlugin, hybrid::testing)

namespace hybrid {
namespace {

using testing::BeaconWorld;

/// Many keyframes leave in every update from the 150th on.
TEST(Departures, AreNoPartOfWhatAChangeIsJudgedBy) {
  IniFile ini("[solver]\nmode = bounded\ncomplete = 150\nsightings = 3", "test.ini");
  const auto judge = std::make_shared<testing::Judge>();
  Mapper mapper(read_motion_options(ini), {make_plugin("BearingRangeKnownIds", ini), judge},
                make_backend(ini.section("solver")), false);
  BeaconWorld world(false);
  for (int i = 0; i < 155; ++i) mapper.add(world.with_detections(i, true));
  EXPECT_GT(mapper.statistics().at("keyframes_marginalized"), 100.0);
  ASSERT_EQ(judge->rises.size(), 155U);
  for (const double rise : judge->rises) {
    EXPECT_LE(rise, 1.0 + 1e-6);
    EXPECT_GT(rise, -10.0);
  }
}

/// The map is the same as if nothing had been tried.
TEST(Departures, AreAsBeforeWhereAChangeIsTurnedDown) {
  for (const char* mode :
       {"bounded\ncomplete = 150\nsightings = 3", "incremental", "fixed_lag\nlag = 30",
        "batch\nsolve_every = 1", "batch\nsolve_every = 7"}) {
    SCOPED_TRACE(mode);
    IniFile ini(std::string("[solver]\nmode = ") + mode, "test.ini");
    const auto judge = std::make_shared<testing::Judge>();
    judge->allowed = 0.5;  // of 1, which each change costs
    const int keyframes = std::string(mode).find("batch") == 0 ? 20 : 200;
    Mapper mapper(read_motion_options(ini), {make_plugin("BearingRangeKnownIds", ini), judge},
                  make_backend(ini.section("solver")), false);
    Mapper alone(read_motion_options(ini), {make_plugin("BearingRangeKnownIds", ini)},
                 make_backend(ini.section("solver")), false);
    mapper.keep_events();
    BeaconWorld world(false), same(false);
    for (int i = 0; i < keyframes; ++i) {
      mapper.add(world.with_detections(i, true));
      alone.add(same.with_detections(i, true));
    }
    EXPECT_EQ(judge->turned_down, keyframes);
    EXPECT_TRUE(judge->rises.empty());
    EXPECT_TRUE(mapper.warnings().empty());
    EXPECT_EQ(mapper.backend().graph().size(), alone.backend().graph().size());
    const Values &tried = mapper.backend().values(), &values = alone.backend().values();
    ASSERT_EQ(tried.size(), values.size());
    for (const Key key : values.keys()) {
      const int n = values.type(key).size;
      EXPECT_EQ(std::vector<double>(tried.data(key), tried.data(key) + n),
                std::vector<double>(values.data(key), values.data(key) + n));
    }
  }
}

/// A start that was found by what the map says too would count twice if it stayed.
TEST(Departures, LeaveTheStartToBeForgotten) {
  for (const char* mode :
       {"bounded\ncomplete = 60\nsightings = 3", "fixed_lag\nlag = 30", "filter", "incremental"}) {
    SCOPED_TRACE(mode);
    IniFile ini(std::string("[solver]\nmode = ") + mode, "test.ini");
    MotionOptions motion = read_motion_options(ini);
    motion.start = KnownStart{Eigen::Isometry3d::Identity(), 1e-6 * Eigen::Matrix3d::Identity()};
    motion.start->found = true;
    Mapper mapper(motion, {make_plugin("BearingRangeKnownIds", ini)},
                  make_backend(ini.section("solver")), false);
    BeaconWorld world(false);
    for (int i = 0; i < 150; ++i) mapper.add(world.with_detections(i, true));
    const std::vector<Key> beacon = {mapper.landmarks().begin()->second.position};
    EXPECT_LT(mapper.backend().joint_covariance(beacon).trace(), 0.1);
    mapper.forget_start();
    EXPECT_GT(mapper.backend().joint_covariance(beacon).trace(), 1.0);  // 1 m on each axis
    for (int i = 150; i < 300; ++i) mapper.add(world.with_detections(i, true));
    const bool keeps_all = std::string(mode) == "incremental";
    EXPECT_EQ(mapper.backend().holds(Key('x', 0)), keeps_all);
  }
}

}  // namespace
}  // namespace hybrid
