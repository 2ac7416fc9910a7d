// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>

#include "tests/apps/replay_runner.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

class EventsTest : public ReplayTest {
 protected:
  /// The lines of events.jsonl of a run, by kind of event, in order.
  std::map<std::string, std::vector<Json>> events_of(const std::string& arguments) const {
    const Ran ran = run_replay(arguments + " --no-pictures --events -o " + at("out"));
    EXPECT_EQ(ran.code, 0) << ran.text;
    std::map<std::string, std::vector<Json>> out;
    std::istringstream lines(read_file(folder / "out" / "events.jsonl"));
    for (std::string line; std::getline(lines, line);) {
      const Json event = Json::parse(line);
      out[event.at("event")].push_back(event);
    }
    return out;
  }
  /// The log of classed_demo, with nobody to say which landmark a detection is of.
  std::string unknown_ids() const {
    const std::string logs = HYBRID_SOURCE_DIR "/rawlogs/classed_demo";
    return "-c " + write("unknown.ini", "[log]\nrawlog = " + logs +
                                            ".rawlog\n[sensor]\nids = none\n[plugins]\n"
                                            "classes = BearingRangeAssociation\n");
  }
  Json landmarks() const { return Json::parse(read("out/landmarks.json")); }
};

// Whoever asks for events gets the same map, to the last bit.
TEST_F(EventsTest, LeaveTheEstimateAsItIs) {
  for (const std::string& arguments :
       {unknown_ids(), "-c " + config("classed_demo.ini"), "-c " + config("slip_demo.ini"),
        "-c " + config("classed_demo.ini") + " --set solver.mode=fixed_lag"}) {
    ASSERT_EQ(run_replay(arguments + " --no-pictures -o " + at("plain")).code, 0);
    ASSERT_EQ(run_replay(arguments + " --no-pictures --events -o " + at("told")).code, 0);
    for (const char* name : {"trajectory.tum", "landmarks.json", "graph.g2o"}) {
      EXPECT_EQ(read_file(folder / "plain" / name), read_file(folder / "told" / name)) << name;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "plain" / "events.jsonl"));
  }
}

TEST_F(EventsTest, AreTheSameEveryTime) {
  ASSERT_EQ(run_replay(unknown_ids() + " --no-pictures --events -o " + at("one")).code, 0);
  ASSERT_EQ(run_replay(unknown_ids() + " --no-pictures --events -o " + at("two")).code, 0);
  EXPECT_GT(read("one/events.jsonl").size(), 10000u);
  EXPECT_EQ(read("one/events.jsonl"), read("two/events.jsonl"));
}

TEST_F(EventsTest, TellWhereEverySightingWent) {
  const auto events = events_of(unknown_ids());
  ASSERT_EQ(events.at("residual").size(), events.at("sighting").size());
  std::map<std::int64_t, int> sightings;
  for (const Json& line : events.at("residual")) {
    if (!line.at("landmark").is_null()) ++sightings[line.at("landmark").get<std::int64_t>()];
  }
  const Json map = landmarks();
  EXPECT_GT(map.at("landmarks").size(), 10u);
  EXPECT_EQ(sightings.size(), map.at("landmarks").size());
  for (const Json& landmark : map.at("landmarks")) {
    EXPECT_EQ(sightings[landmark.at("id").get<std::int64_t>()], landmark.at("sightings"));
  }
  std::set<std::int64_t> alive;
  for (const Json& line : events.at("birth")) alive.insert(line.at("landmark").get<std::int64_t>());
  EXPECT_GE(alive.size(), map.at("landmarks").size());
}

// A sighting belongs to what the best hypothesis of its frame says, and its candidate is admitted.
TEST_F(EventsTest, SayWhyASightingWasGivenToItsLandmark) {
  const auto events = events_of(unknown_ids());
  std::map<std::int64_t, Json> sighting;
  for (const Json& line : events.at("sighting")) sighting[line.at("sighting")] = line;
  int matched = 0;
  for (const Json& line : events.at("association")) {
    const Json& best = line.at("hypotheses").front();
    EXPECT_EQ(best.at("log_odds"), 0.0);
    for (std::size_t i = 0; i < line.at("sightings").size(); ++i) {
      const Json& one = sighting.at(line.at("sightings")[i]);
      const Json& landmark = best.at("landmarks")[i];
      if (landmark.is_null()) continue;
      ++matched;
      EXPECT_EQ(one.at("landmark"), landmark);
      const Json& candidates = one.at("candidates");
      const auto own = std::find_if(candidates.begin(), candidates.end(),
                                    [&](const Json& c) { return c.at("landmark") == landmark; });
      ASSERT_NE(own, candidates.end());
      EXPECT_TRUE(own->at("log_odds").is_number());
      EXPECT_EQ(own->at("nis"), one.at("nis"));
    }
  }
  EXPECT_GT(matched, 100);
}

// On average an innovation has as many squared sigmas as coordinates.
TEST_F(EventsTest, NormalisedInnovationsAreThoseOfAnHonestFilter) {
  const auto events = events_of("-c " + config("classed_demo.ini"));
  double sum = 0;
  int count = 0;
  for (const Json& line : events.at("sighting")) {
    if (!line.contains("nis")) continue;
    sum += line.at("nis").get<double>();
    ++count;
  }
  ASSERT_GT(count, 100);
  // Mean of chi-square with 2 degrees of freedom, +- four standard deviations of the mean.
  EXPECT_NEAR(sum / count, 2.0, 4 * 2 / std::sqrt(count));
}

TEST_F(EventsTest, ObjectiveNeverRisesWithinAChangeAndFlipsNameTheirHalfStep) {
  const auto events = events_of("-c " + config("slip_demo.ini"));
  std::size_t flips = 0;
  for (const Json& line : events.at("change")) {
    const auto objectives = line.at("objectives").get<std::vector<double>>();
    for (std::size_t i = 1; i < objectives.size(); ++i) {
      EXPECT_LE(objectives[i], objectives[i - 1] + 1e-9 * (1 + std::abs(objectives[i - 1])));
    }
    for (const Json& flip : line.at("flips")) {
      ++flips;
      EXPECT_NE(flip.at("from"), flip.at("to"));
      EXPECT_LT(flip.at("half_step"), objectives.size());
      EXPECT_GT(flip.at("half_step"), 0u);
    }
  }
  EXPECT_GT(flips, 0u);
}

// What the sightings add up to is what the solver finds, and what the map says.
TEST_F(EventsTest, LastBeliefsAreThoseOfTheMap) {
  const auto events = events_of("-c " + config("classed_demo.ini"));
  const Json names = events.at("classes").back().at("names");
  const Json map = landmarks().at("landmarks");
  const std::vector<Json>& beliefs = events.at("belief");
  ASSERT_GT(beliefs.size(), 2 * map.size());
  std::map<std::int64_t, Json> on_the_way, last;
  for (std::size_t i = 0; i < beliefs.size(); ++i) {
    auto& into = i + map.size() < beliefs.size() ? on_the_way : last;
    into[beliefs[i].at("landmark").get<std::int64_t>()] = beliefs[i].at("probabilities");
  }
  for (const Json& landmark : map) {
    const auto id = landmark.at("id").get<std::int64_t>();
    for (std::size_t c = 0; c < names.size(); ++c) {
      const double p = landmark.at("class_probabilities").at(names[c].get<std::string>());
      EXPECT_EQ(last.at(id)[c], p);
      EXPECT_NEAR(on_the_way.at(id)[c], p, 1e-9);
    }
  }
}

TEST_F(EventsTest, MergesMoveTheirSightings) {
  const auto events = events_of("-c " + config("kf_slam_demo.ini") +
                                " --set sensor.ids=none"
                                " --set plugins.classes=BearingRangeAssociation");
  EXPECT_GT(events.count("merge") + events.count("loop"), 0u);
  std::set<std::int64_t> gone;
  for (const char* kind : {"merge", "loop"}) {
    if (events.count(kind) == 0) continue;
    for (const Json& line : events.at(kind)) {
      EXPECT_GT(line.at("evidence").get<double>(), 0.0);
      for (const Json& pair : line.at("pairs")) {
        if (!line.at("undone").get<bool>()) gone.insert(pair[0].get<std::int64_t>());
      }
    }
  }
  for (const Json& line : events.at("removal")) gone.erase(line.at("landmark"));
  EXPECT_TRUE(gone.empty());
}

// A solver that works at the end has no innovations on the way, but tells all else.
TEST_F(EventsTest, OfABatchHaveNoInnovations) {
  const auto events = events_of("-c " + config("classed_demo.ini") + " --set solver.mode=batch");
  EXPECT_FALSE(events.at("sighting").back().contains("nis"));
  EXPECT_EQ(events.at("residual").size(), events.at("sighting").size());
  EXPECT_GT(events.at("change").back().at("objectives").size(), 2u);
}

}  // namespace
}  // namespace hybrid
