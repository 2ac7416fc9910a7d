// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_tracks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/libhybrid/landmarks/track_graph.h"

namespace hybrid {
namespace {

using testing::kCar;
using testing::kTree;
using testing::TrackGraph;

auto state_of(const Track& track) {
  return std::make_tuple(track.sightings, track.prior, track.alive, track.existence,
                         track.last_keyframe, track.class_evidence, track.sigma);
}

std::vector<int> near_origin(const LandmarkTracks& tracks) {
  std::vector<int> out;
  tracks.grid().visit_near(0, 0, 1000, [&](int t) { out.push_back(t); });
  std::sort(out.begin(), out.end());
  return out;
}

/// A contribution of everything that a track can go through.
void change(std::mt19937& random, TrackGraph& world, Contribution& out) {
  LandmarkTracks& tracks = world.tracks;
  const auto any = [&](std::size_t n) { return static_cast<int>(random() % n); };
  for (int k = 0; k < 6; ++k) {
    std::vector<int> alive;
    for (int t = 0; t < static_cast<int>(tracks.tracks().size()); ++t) {
      if (tracks.track(t).alive) alive.push_back(t);
    }
    const Eigen::Vector2d point(1 + any(9), any(9));
    const std::vector<double> phi = any(3) == 0 ? std::vector<double>{} : any(2) ? kTree : kCar;
    const int what = any(4);
    if (what == 0 || alive.size() < 3) {
      world.create(world.see(point, phi), out);
    } else if (what == 1) {
      tracks.attach(world.see(point, phi), alive[any(alive.size())], false, out);
    } else if (what == 2) {
      const int from = alive[any(alive.size())];
      const int into = alive[any(alive.size())];
      // What this contribution itself has made has no handles yet, by which it could be removed.
      const bool is_applied = !tracks.track(from).prior.empty();
      const auto& own = tracks.track(from).sightings;
      const bool all_applied = std::all_of(
          own.begin(), own.end(), [&](int s) { return !tracks.sighting(s).factors.empty(); });
      if (from != into && is_applied && all_applied) tracks.merge(from, into, false, out);
    } else {
      const auto& own = tracks.track(alive[any(alive.size())]).sightings;
      if (own.size() > 1 && !tracks.sighting(own.back()).factors.empty()) {
        tracks.detach(own.back(), out);
      }
    }
  }
}

TEST(LandmarkTracks, TheGraphHoldsEachSightingOfATrackOnceAndAPriorForEach) {
  std::mt19937 random(3);
  TrackGraph world;
  for (int round = 0; round < 60; ++round) {
    Contribution out;
    change(random, world, out);
    world.apply(out);
    std::size_t plain = 0, classed = 0, alive = 0;
    for (const Track& track : world.tracks.tracks()) {
      if (!track.alive) continue;
      ++alive;
      for (const int s : track.sightings) {
        ++(world.tracks.sighting(s).phi.empty() ? plain : classed);
      }
    }
    ASSERT_EQ(world.graph.continuous().size(), plain);
    ASSERT_EQ(world.graph.hybrid().size(), classed);
    ASSERT_EQ(world.graph.discrete().size(), alive);
    ASSERT_EQ(world.values.size(), alive);
    ASSERT_EQ(world.registry.size(), alive);
    ASSERT_EQ(world.tracks.alive(), alive);
    for (const auto& [id, landmark] : world.registry) {
      const auto& sightings = world.tracks.track(static_cast<int>(id)).sightings;
      ASSERT_EQ(landmark.sightings, static_cast<int>(sightings.size()));
    }
  }
  EXPECT_GT(world.graph.size(), 50U);
}

TEST(LandmarkTracks, ARefusedContributionLeavesTheTracksAsTheyWere) {
  std::mt19937 random(5);
  TrackGraph world;
  for (int round = 0; round < 60; ++round) {
    for (int t = 0; t < static_cast<int>(world.tracks.tracks().size()); ++t) {
      world.tracks.track(t).existence = 0.1 * t;
      world.tracks.track(t).last_keyframe = t;
    }
    const LandmarkTracks before = world.tracks;
    Contribution out;
    change(random, world, out);
    for (int t = 0; t < static_cast<int>(world.tracks.tracks().size()); ++t) {
      world.tracks.set(t, &Track::existence, 7.0);
      world.tracks.set(t, &Track::sigma, 7.0);
      if (world.tracks.track(t).alive && t % 3 == 0) world.tracks.retire(t, out);
    }
    Values moved;
    for (const Track& track : world.tracks.tracks()) {
      moved.insert(track.position, Eigen::Vector2d(random() % 100, random() % 100));
    }
    world.tracks.place_all(moved);
    world.tracks.take_back();
    for (std::size_t t = 0; t < before.tracks().size(); ++t) {
      const Track &was = before.tracks()[t], &is = world.tracks.tracks()[t];
      ASSERT_EQ(state_of(is), state_of(was)) << "track " << t << " in round " << round;
      if (!is.alive) continue;
      ASSERT_EQ(world.tracks.grid().middle(static_cast<int>(t)),
                before.grid().middle(static_cast<int>(t)));
    }
    ASSERT_EQ(world.tracks.tracks().size(), before.tracks().size());
    ASSERT_EQ(world.tracks.sightings().size(), before.sightings().size());
    for (std::size_t s = 0; s < before.sightings().size(); ++s) {
      ASSERT_EQ(world.tracks.sightings()[s].track, before.sightings()[s].track);
      ASSERT_EQ(world.tracks.sightings()[s].factors, before.sightings()[s].factors);
    }
    ASSERT_EQ(near_origin(world.tracks), near_origin(before));
    ASSERT_EQ(world.tracks.alive(), before.alive());
    Contribution kept;  // and life goes on
    change(random, world, kept);
    world.apply(kept);
  }
}

TEST(LandmarkTracks, MergingKeepsAllSightingsAndAllThatTheySayOfTheClass) {
  TrackGraph world;
  const int a = world.landmark({5, 1}, kTree, 3), b = world.landmark({5, 1.1}, kCar, 2);
  const std::vector<double> alone = world.tracks.class_belief(world.tracks.track(a), world.classes);
  std::set<int> sightings(world.tracks.track(a).sightings.begin(),
                          world.tracks.track(a).sightings.end());
  sightings.insert(world.tracks.track(b).sightings.begin(), world.tracks.track(b).sightings.end());
  Contribution out;
  world.tracks.merge(b, a, false, out);
  world.apply(out);
  const std::vector<int>& merged = world.tracks.track(a).sightings;
  EXPECT_EQ(std::set<int>(merged.begin(), merged.end()), sightings);
  EXPECT_EQ(merged.size(), 5U);
  EXPECT_TRUE(std::is_sorted(merged.begin(), merged.end()));
  EXPECT_FALSE(world.tracks.track(b).alive);
  EXPECT_EQ(world.graph.hybrid().size(), 5U);
  EXPECT_EQ(world.registry.find(a)->sightings, 5);
  EXPECT_EQ(world.registry.find(b), nullptr);
  // Three for a tree and two against it: as one for it.
  EXPECT_NEAR(alone[0], 729.0 / 730, 1e-12);
  EXPECT_NEAR(world.tracks.class_belief(world.tracks.track(a), world.classes)[0], 0.9, 1e-12);
}

TEST(LandmarkTracks, TwoSeenInOneFrameAreTwo) {
  std::mt19937 random(1);
  for (int round = 0; round < 50; ++round) {
    TrackGraph world;
    std::vector<std::set<int>> frames(2);
    std::vector<int> tracks(2);
    Contribution out;
    std::vector<std::pair<int, int>> seen;  // frame, track
    for (int f = 0; f < 6; ++f) {
      for (int k = 0; k < 2; ++k) {
        if (f != k && random() % 4 != 0) continue;
        seen.emplace_back(2 * f + static_cast<int>(random() % 2), k);
      }
    }
    std::sort(seen.begin(), seen.end());
    for (const auto& [frame, k] : seen) {
      const int s = world.see({3, 1.0 + k}, {}, frame);
      if (frames[k].empty()) {
        tracks[k] = world.create(s, out);
      } else {
        world.tracks.attach(s, tracks[k], false, out);
      }
      frames[k].insert(frame);
    }
    const bool together = std::any_of(frames[0].begin(), frames[0].end(),
                                      [&](int f) { return frames[1].count(f) != 0; });
    EXPECT_EQ(world.tracks.seen_together(tracks[0], tracks[1]), together);
    EXPECT_EQ(world.tracks.seen_together(tracks[1], tracks[0]), together);
  }
}

TEST(LandmarkTracks, EvidenceOfOneClassGrowsWithAgreementAndFallsWithContradiction) {
  TrackGraph world;
  const int a = world.landmark({5, 0}, kTree, 4), b = world.landmark({6, 0}, kTree, 4);
  const int c = world.landmark({7, 0}, kCar, 4), unseen = world.landmark({8, 0});
  EXPECT_GT(world.tracks.same_class(a, b, world.classes), 0.5);
  EXPECT_LT(world.tracks.same_class(a, c, world.classes), -1);
  EXPECT_NEAR(world.tracks.same_class(a, unseen, world.classes), 0, 1e-12);
  EXPECT_EQ(world.tracks.same_class(a, c, world.classes),
            world.tracks.same_class(c, a, world.classes));
}

/// Two landmarks that become one were not both seen in a frame: one of the sightings was clutter.
TEST(LandmarkTracks, OfTwoSightingsInOneFrameAMergeLeavesOne) {
  TrackGraph world(std::vector<std::string>{});
  const int a = world.landmark({10, 0}, {}, 3), b = world.landmark({10.1, 0}, {}, 2);
  Contribution out;
  const int frame = ++world.frames;
  const int kept = world.see({10, 0}, {}, frame), lost = world.see({10.1, 0}, {}, frame);
  world.tracks.attach(kept, a, false, out);
  world.tracks.attach(lost, b, false, out);
  world.apply(out);
  EXPECT_EQ(world.tracks.sightings_beside(a, b).size(), 1U);
  Contribution merge;
  world.tracks.merge(b, a, false, merge);
  world.apply(merge);
  EXPECT_EQ(world.tracks.track(a).sightings.size(), 6U);
  EXPECT_EQ(world.tracks.sighting(kept).track, a);
  EXPECT_EQ(world.tracks.sighting(lost).track, -1);
  EXPECT_TRUE(world.tracks.sighting(lost).factors.empty());
  EXPECT_EQ(world.graph.continuous().size(), 6U);
  EXPECT_EQ(world.registry.find(a)->sightings, 6);
}

}  // namespace
}  // namespace hybrid
