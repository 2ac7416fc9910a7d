// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// A back-end that refuses what plugins say in some keyframes: the map goes on without it.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <new>
#include <thread>
#include <utility>

#include "tests/mrpt_plugins/plugins/beacon_world.h"

namespace hybrid::testing {

/// Says nothing, and counts what it is asked and answered.
class Listener : public MappingPlugin {
  DEFINE_MRPT_OBJECT(Listener, hybrid::testing)

 public:
  void configure(IniSection) override {}
  Contribution observe(const Frame&, const MapView&) override {
    ++asked;
    return {};
  }
  void applied(const Outcome&) override { ++answered; }
  void refused() override { ++answered; }

  int asked = 0, answered = 0;
};

}  // namespace hybrid::testing

IMPLEMENTS_MRPT_OBJECT(Listener, hybrid::MappingPlugin, hybrid::testing)

namespace hybrid {
namespace {

using testing::BeaconWorld;

bool is_of_landmark(Key key) {
  return key.letter() == 'l';
}

constexpr std::chrono::milliseconds kSlow(20);

/// Refuses every change with a landmark in it while it is told to.
class Refusing : public Backend {
 public:
  Refusing(std::unique_ptr<Backend> inner, const bool& refuses)
      : inner_(std::move(inner)), refuses_(refuses) {}

  /// When it refuses: whether memory lacks for what comes without a motion.
  bool lacks_memory = false;
  /// Whether it refuses changes without landmarks, too.
  bool refuses_all = false;

  std::string mode() const override { return inner_->mode(); }
  BackendReport update(const Delta& delta) override {
    const auto has_landmark = [](const auto& factor) {
      return std::any_of(factor->keys().begin(), factor->keys().end(), is_of_landmark);
    };
    if (refuses_all) throw Error("refused");
    if (refuses_ && (std::any_of(delta.continuous.begin(), delta.continuous.end(), has_landmark) ||
                     std::any_of(delta.hybrid.begin(), delta.hybrid.end(), has_landmark))) {
      if (lacks_memory && delta.values.keys().empty()) throw std::bad_alloc();
      throw Error("refused");
    }
    return inner_->update(delta);
  }
  BackendReport propose(const Proposal& proposal) override { return inner_->propose(proposal); }
  BackendReport finish() override {
    std::this_thread::sleep_for(kSlow);  // beside what it reports
    return inner_->finish();
  }
  const Values& values() const override { return inner_->values(); }
  const Assignment& assignment() const override { return inner_->assignment(); }
  const HybridGraph& graph() const override { return inner_->graph(); }
  bool keeps_all() const override { return inner_->keeps_all(); }
  bool holds(Key key) const override { return inner_->holds(key); }
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const override {
    return inner_->joint_covariance(keys);
  }
  Uncertainty uncertainty(const std::vector<Key>& continuous,
                          const std::vector<DiscreteKey>& discrete) const override {
    return inner_->uncertainty(continuous, discrete);
  }

 private:
  std::unique_ptr<Backend> inner_;
  const bool& refuses_;
};

struct Case {
  const char* plugin;
  Keyframe (*keyframe)(BeaconWorld&, int);
};

class Refusal : public ::testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(
    Plugins, Refusal,
    ::testing::Values(
        Case{"BearingRangeKnownIds",
             [](BeaconWorld& w, int i) { return w.with_detections(i, true); }},
        Case{"ClassedBearingRangeKnownIds",
             [](BeaconWorld& w, int i) { return w.with_detections(i, true); }},
        Case{"BearingRangeAssociation",
             [](BeaconWorld& w, int i) { return w.with_detections(i, false); }},
        Case{"BearingOnlyKnownIds", [](BeaconWorld& w, int i) { return w.with_bearings(i); }},
        Case{"BeaconRanges", [](BeaconWorld& w, int i) { return w.with_ranges(i, 0.3); }}),
    [](const auto& info) { return info.param.plugin; });

TEST_P(Refusal, LosesTheObservationsOfTheKeyframeAndNothingElse) {
  for (const char* mode : {"incremental", "fixed_lag\nlag = 200", "batch\nsolve_every = 1"}) {
    SCOPED_TRACE(mode);
    IniFile ini(std::string("[solver]\nmode = ") + mode, "test.ini");
    BeaconWorld world(false);
    bool refuses = false;
    Mapper mapper(read_motion_options(ini), {make_plugin(GetParam().plugin, ini)},
                  std::make_unique<Refusing>(make_backend(ini.section("solver")), refuses), false);
    constexpr int kKeyframes = 60;
    for (int i = 0; i < kKeyframes; ++i) {
      refuses = i == 0 || i == 9 || (20 <= i && i < 24) || i == 40;
      mapper.add(GetParam().keyframe(world, i));
    }
    refuses = false;
    EXPECT_GE(mapper.finish().seconds, std::chrono::duration<double>(kSlow).count());
    EXPECT_GE(mapper.dropped().at("observations dropped: not usable"), 4U);
    EXPECT_EQ(mapper.warnings().size(), mapper.dropped().at("observations dropped: not usable"));
    const MapResult result = mapper.result();
    EXPECT_EQ(result.trajectory.size(), static_cast<std::size_t>(kKeyframes));
    EXPECT_LE(mapper.decisions().size(), kKeyframes * world.beacons.size());
    ASSERT_EQ(result.landmarks.size(), world.beacons.size());
    for (const Eigen::Vector3d& truth : world.beacons) {
      double nearest = INFINITY;
      for (const LandmarkEstimate& l : result.landmarks) {
        nearest = std::min(nearest, (l.position - truth).norm());
      }
      EXPECT_LT(nearest, 0.5);
    }
  }
}

// The motion of the keyframes that are dropped is not lost: the map is the same but for their
// poses.
TEST(RefusalOfAPose, DropsTheKeyframeAndItsMotionGoesOn) {
  IniFile ini("[solver]\nmode = incremental", "test.ini");
  const auto map_of = [&](const std::vector<int>& refused) {
    BeaconWorld world(false);
    bool refuses = false;
    auto backend = std::make_unique<Refusing>(make_backend(ini.section("solver")), refuses);
    Refusing& gate = *backend;
    Mapper mapper(read_motion_options(ini), {make_plugin("BearingRangeKnownIds", ini)},
                  std::move(backend), false);
    for (int i = 0; i < 40; ++i) {
      gate.refuses_all = std::find(refused.begin(), refused.end(), i) != refused.end();
      EXPECT_EQ(mapper.add(world.with_detections(i, true)) == nullptr, gate.refuses_all) << i;
    }
    mapper.finish();
    if (!refused.empty()) {
      EXPECT_EQ(mapper.dropped().at("keyframe dropped: not usable"), refused.size());
      EXPECT_FALSE(mapper.dropped().count("odometry missing: robot taken to stand still"));
    }
    return mapper.result();
  };
  const MapResult whole = map_of({});
  const std::vector<int> refused = {9, 20, 21, 22, 39};
  const MapResult rest = map_of(refused);
  ASSERT_EQ(rest.trajectory.size() + refused.size(), whole.trajectory.size());
  for (std::size_t i = 0, k = 0; i < whole.trajectory.size(); ++i) {
    if (std::find(refused.begin(), refused.end(), static_cast<int>(i)) != refused.end()) continue;
    const TimedPose &with = whole.trajectory[i], &without = rest.trajectory[k];
    EXPECT_EQ(with.time, without.time);
    EXPECT_LT((with.pose - without.pose).norm(), 0.05);
    EXPECT_LT((whole.dead_reckoning[i].pose - rest.dead_reckoning[k].pose).norm(), 1e-9);
    ++k;
  }
}

// Those after the one for which memory lacks, too.
TEST(RefusalOfMemory, AnswersEveryPluginWhereMemoryLacks) {
  IniFile ini("[solver]\nmode = incremental", "test.ini");
  BeaconWorld world(false);
  bool refuses = false;
  auto backend = std::make_unique<Refusing>(make_backend(ini.section("solver")), refuses);
  backend->lacks_memory = true;
  const auto before = std::make_shared<testing::Listener>();
  const auto after = std::make_shared<testing::Listener>();
  Mapper mapper(read_motion_options(ini), {before, make_plugin("BearingRangeKnownIds", ini), after},
                std::move(backend), false);
  for (int i = 0; i < 5; ++i) mapper.add(world.with_detections(i, true));
  refuses = true;
  EXPECT_THROW(mapper.add(world.with_detections(5, true)), std::bad_alloc);
  EXPECT_EQ(before->asked, 6);
  EXPECT_EQ(after->asked, 6);
  EXPECT_EQ(before->answered, 6);
  EXPECT_EQ(after->answered, 6);
}

}  // namespace
}  // namespace hybrid
