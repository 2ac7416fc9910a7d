// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <set>

#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/map_style.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// A round trip past landmarks of six classes.
MapResult round_trip(bool is_3d) {
  MapResult map;
  map.title = "round trip";
  map.is_3d = is_3d;
  map.class_names = {"a", "b", "c", "d", "e", "f"};
  for (int i = 0; i <= 100; ++i) {
    const double angle = 2 * M_PI * i / 100;
    const double height = is_3d ? std::sin(2 * angle) : 0;
    map.trajectory.push_back(
        {0.1 * i, CPose3D(5 * std::cos(angle), 4 * std::sin(angle), height, angle, 0, 0)});
    map.dead_reckoning.push_back({0.1 * i, CPose3D(5 * std::cos(angle) + 0.02 * i,
                                                   4 * std::sin(angle), height, angle, 0, 0)});
  }
  for (int i = 0; i < 12; ++i) {
    LandmarkEstimate l;
    l.id = i;
    l.is_3d = is_3d;
    l.position = {7 * std::cos(i), 6 * std::sin(i), is_3d ? 0.5 * i : 0};
    l.covariance = Eigen::Vector3d(0.01, 0.04, is_3d ? 0.02 : 0).asDiagonal();
    l.class_index = i % 6;
    map.landmarks.push_back(l);
  }
  return map;
}

GroundTruth truth_of(const MapResult& map) {
  GroundTruth truth;
  truth.path = map.trajectory;
  for (const LandmarkEstimate& l : map.landmarks) {
    truth.landmarks.push_back({l.id, l.position, l.class_index});
  }
  return truth;
}

/// A drive along a corridor that laser scans alone show.
MapResult corridor() {
  MapResult map;
  for (int i = 0; i <= 50; ++i) {
    map.trajectory.push_back({0.1 * i, CPose3D(0.2 * i, 0, 0, 0, 0, 0)});
  }
  GridMap grid;
  grid.resolution = 0.1;
  grid.corner = {-1, -2};
  grid.width = 120;
  grid.height = 40;
  grid.cells.assign(120 * 40, GridMap::kFree);
  for (std::size_t x = 0; x < 120; ++x)
    grid.cells[x] = grid.cells[39 * 120 + x] = GridMap::kOccupied;
  map.grid = std::make_shared<const GridMap>(grid);
  return map;
}

int count(const Image& image, Color color, int tolerance = 12) {
  int n = 0;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const int distance =
        std::max({std::abs(image.rgb[i] - color.red), std::abs(image.rgb[i + 1] - color.green),
                  std::abs(image.rgb[i + 2] - color.blue)});
    if (distance <= tolerance) ++n;
  }
  return n;
}

TEST(MapImage, ShowsPathsAndEveryClassInItsColour) {
  const MapResult map = round_trip(false);
  const Image image = map_image(map, truth_of(map));
  EXPECT_EQ(image.width, 1600);
  EXPECT_EQ(image.height, 1200);
  EXPECT_GT(count(image, palette::kEstimate), 2000);
  EXPECT_GT(count(image, palette::kDeadReckoning), 500);
  EXPECT_GT(count(image, palette::kTruth), 2000);
  for (std::size_t c = 0; c < 6; ++c) EXPECT_GT(count(image, series_color(c)), 200) << c;
  EXPECT_GT(count(image, palette::kWhite), 1000000);
}

TEST(MapImage, DrawsOnlyWhatIsGiven) {
  MapResult map = round_trip(false);
  map.dead_reckoning.clear();
  const Image image = map_image(map);
  EXPECT_EQ(count(image, palette::kDeadReckoning), 0);
  EXPECT_EQ(map_image({}).width, 1600);
}

TEST(MapImage, ShowsExtentsAndHowManyThingsALandmarkStandsFor) {
  const MapResult single = round_trip(false);
  MapResult extended = single, several = single;
  extended.landmarks[0].size.extent = 0.5;
  several.landmarks[0].size.things = 2;
  const auto drawn = [](const MapResult& map) { return map_image(map, {}).rgb; };
  EXPECT_NE(drawn(extended), drawn(single));
  EXPECT_NE(drawn(several), drawn(single));
  EXPECT_NE(drawn(several), drawn(extended));
}

TEST(MapImage, OfAFilmHasAClockAndRaysToWhatIsSeen) {
  const MapResult map = round_trip(false);
  const auto rays = [&](const std::vector<std::int64_t>& seen) {
    const Image image = map_image(map, {}, 1600, 1200, map_frame(map, {}), {"after 3 s, ", seen});
    EXPECT_NE(image.rgb, map_image(map).rgb);
    return count(image, map_style::kSight.color, 40);
  };
  const std::int64_t a = map.landmarks[1].id, b = map.landmarks[3].id, unknown = 12345;
  EXPECT_GT(rays({a}), rays({}) + 20);
  EXPECT_GT(rays({a, b, unknown}), rays({a}) + 10);
}

/// A map with fixes of all kinds, three false ones far away.
MapResult with_fixes() {
  MapResult map = round_trip(false);
  map.datum = MapDatum();
  for (std::size_t i = 0; i < 100; ++i) {
    const auto& pose = map.trajectory[i].pose;
    FixEstimate fix;
    fix.antenna = {pose.x(), pose.y(), 0};
    fix.measured = fix.antenna + Eigen::Vector3d(0.2, 0.1, 0);
    if (i % 10 < 8) fix.mode = FixMode::kGood;
    if (i % 10 == 8) fix.mode = FixMode::kBiased;
    if (fix.mode == FixMode::kBiased) fix.measured.x() += 0.7;
    if (i < 3 || i % 10 == 7) fix.mode = FixMode::kFalse;
    if (i % 10 == 7) fix.measured.y() += 0.9;
    if (i < 3) fix.measured.y() += 1e4;
    map.fixes.push_back(fix);
  }
  return map;
}

TEST(MapImage, ShowsFixesByTheirModes) {
  MapResult map = with_fixes();
  const auto marks = [&] {
    const Image image = map_image(map);
    return std::array<int, 4>{
        count(image, map_style::kGoodFix), count(image, map_style::kBiasedFix),
        count(image, map_style::kFalseFix), count(image, map_style::kUnusedFix, 2)};
  };
  const auto shown = marks();
  map.datum.reset();  // where they are is not known
  const auto hidden = marks();
  for (std::size_t i = 0; i < shown.size(); ++i) EXPECT_GT(shown[i], hidden[i] + 30) << i;
}

TEST(MapStyle, FarFixesDoNotShrinkTheMap) {
  const Extent with = map_extent(with_fixes(), {}), without = map_extent(round_trip(false), {});
  EXPECT_TRUE((with.low == without.low).all());
  EXPECT_TRUE((with.high == without.high).all());
}

TEST(MapImage, SurvivesValuesThatAreNotFinite) {
  MapResult map = round_trip(true);
  map.landmarks[0].position.x() = std::nan("");
  map.landmarks[1].covariance.setConstant(INFINITY);
  map.trajectory[5].pose.x(std::nan(""));
  EXPECT_GT(count(map_image(map, truth_of(map)), palette::kEstimate), 2000);
}

TEST(MapStyle, ClassesDifferInColourAndShape) {
  std::set<std::pair<int, int>> seen;
  for (std::size_t c = 0; c < 36; ++c) {
    const Color color = series_color(c);
    seen.emplace(color.red * 65536 + color.green * 256 + color.blue,
                 static_cast<int>(class_marker(c)));
  }
  EXPECT_EQ(seen.size(), 36u);
}

TEST(MapStyle, EllipsesAreEnlargedOnlyWhenTheyWouldNotShow) {
  auto landmarks = round_trip(false).landmarks;
  EXPECT_EQ(ellipse_magnification(landmarks, 10), 1);
  for (LandmarkEstimate& l : landmarks) l.covariance *= 1e-4;
  const double factor = ellipse_magnification(landmarks, 10);
  EXPECT_GT(factor, 5);
  EXPECT_NE(ellipse_note(factor).find("enlarged"), std::string::npos);
  EXPECT_EQ(ellipse_magnification({}, 10), 1);
}

TEST(MapStyle, TheLessProbableAClassThePalerIsTheLandmark) {
  LandmarkEstimate landmark = round_trip(false).landmarks.front();
  const Color full = landmark_fill(landmark);
  EXPECT_EQ(full.blue, landmark_color(landmark).blue);
  int before = full.blue;
  for (const double p : {0.9, 0.5, 0.2}) {
    landmark.class_probabilities = {p, 1 - p, 0, 0, 0, 0};
    EXPECT_GT(landmark_fill(landmark).blue, before) << p;
    before = landmark_fill(landmark).blue;
  }
  MapResult map = round_trip(false);
  const int sure = count(map_image(map), series_color(0));
  for (LandmarkEstimate& l : map.landmarks) l.class_probabilities.assign(6, 1.0 / 6);
  EXPECT_LT(count(map_image(map), series_color(0)), sure);
}

TEST(MapStyle, CountsRobotsByNameAndThoseWithoutOneBySession) {
  MapResult map = round_trip(false);
  EXPECT_EQ(whose(map), "the robot");
  map.robots = {{"session 1", {0}, true}, {"session 2", {1}, true}};
  EXPECT_EQ(whose(map), "2 sessions");
  map.robots = {{"anna", {0}, false}, {"bob", {1}, false}, {"anna", {2}, false}};
  EXPECT_EQ(whose(map), "2 robots");
  map.robots.push_back({"session 3", {3}, true});
  EXPECT_EQ(whose(map), "2 robots and 1 session");
}

TEST(MapStyle, AMapOfScansAloneListsNoLandmarks) {
  MapResult map = corridor();
  EXPECT_EQ(contents_of(map), "51 poses of the robot");
  map.landmarks = round_trip(false).landmarks;
  EXPECT_EQ(contents_of(map), "51 poses of the robot, 12 landmarks");
  map.landmarks.clear();
  map.grid = nullptr;  // a log in which no landmark was found
  EXPECT_EQ(contents_of(map), "51 poses of the robot, 0 landmarks");
}

TEST(MapStyle, DeadReckoningUnderTheEstimateIsNotListed) {
  MapResult map = round_trip(false);
  const Extent extent = map_extent(map, {});
  EXPECT_FALSE(is_hidden(map.dead_reckoning, map.trajectory, extent));
  const int apart = count(map_image(map), palette::kDeadReckoning);
  map.dead_reckoning = map.trajectory;
  EXPECT_TRUE(is_hidden(map.dead_reckoning, map.trajectory, extent));
  EXPECT_LT(count(map_image(map), palette::kDeadReckoning), apart / 10);
}

TEST(MapStyle, AFarDeadReckoningDoesNotShrinkTheMap) {
  MapResult map = round_trip(false);
  const Extent before = map_extent(map, {});
  map.dead_reckoning.push_back({99, CPose3D(1e4, 0, 0, 0, 0, 0)});
  const Extent after = map_extent(map, {});
  EXPECT_EQ(after.high.x(), before.high.x());
  EXPECT_EQ(after.low.x(), before.low.x());
}

TEST(MapStyle, AThingHasOneColour) {
  const Color colors[] = {map_style::kEstimate.color,        map_style::kDeadReckoning.color,
                          map_style::kTruth.color,           map_style::kRejectedClosure.color,
                          map_style::kAcceptedClosure.color, map_style::kUndecidedClosure.color};
  std::set<std::uint32_t> different;
  for (const Color& c : colors) different.insert(c.red << 16U | c.green << 8U | c.blue);
  EXPECT_EQ(different.size(), std::size(colors));
}

}  // namespace
}  // namespace hybrid
