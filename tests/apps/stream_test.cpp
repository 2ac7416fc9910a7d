// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "tests/apps/piped_program.h"
#include "tests/apps/replay_runner.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"

namespace hybrid {
namespace {

using Json = nlohmann::json;

const std::string kLog = HYBRID_SOURCE_DIR "/rawlogs/classed_demo.rawlog";
const std::string kSettings =
    " --set map.dimension=2 --set plugins.classes=ClassedBearingRangeKnownIds --no-pictures";

/// The plain bytes of the log, cut behind every sensory frame.
std::vector<std::string> entries_of_log() {
  std::string plain = decode(read_file(kLog)).bytes;
  mrpt::io::CMemoryStream stream;
  stream.assignMemoryNotOwn(plain.data(), plain.size());
  auto archive = mrpt::serialization::archiveFrom(stream);
  std::vector<std::string> entries;
  for (std::size_t begin = 0; stream.getPosition() < plain.size();) {
    const auto object = archive.ReadObject();
    if (!IS_CLASS(*object, mrpt::obs::CSensoryFrame)) continue;
    entries.push_back(plain.substr(begin, stream.getPosition() - begin));
    begin = stream.getPosition();
  }
  return entries;
}

class StreamTest : public ReplayTest {
 protected:
  std::string piped(const std::string& more = "") const {
    return "hybrid-replay --rawlog - --stream" + kSettings + " " + more + " -o " + at("out");
  }
  /// Exit code, and standard error, of a replay of these bytes.
  Ran pipe_in(const std::string& bytes) const {
    return run_shell("cat " + write("in", bytes) + " | " HYBRID_BINARY_DIR "/bin/" + piped() +
                     " 2>&1 >/dev/null");
  }
};

using Compress = std::string (*)(const std::string&);

// An entry is written when the line of the one before has come.
TEST_F(StreamTest, TellsEveryKeyframeWhenItsEntryHasCome) {
  const std::vector<std::string> entries = entries_of_log();
  ASSERT_EQ(entries.size(), 189U);
  ASSERT_EQ(run_replay(kLog + kSettings + " -o " + at("file")).code, 0);
  const Compress forms[] = {[](const std::string& bytes) { return bytes; },
                            [](const std::string& bytes) { return gzip(bytes); },
                            [](const std::string& bytes) { return zstd(bytes); }};
  for (const Compress form : forms) {
    PipedProgram program(piped("--events"), at("error"));
    std::vector<Json> lines;
    for (const std::string& entry : entries) {
      program.write(form(entry));
      const std::string line = program.line();
      ASSERT_NE(line, "") << lines.size();
      lines.push_back(Json::parse(line));
      ASSERT_EQ(lines.back()["keyframe"], lines.size() - 1);
    }
    program.end_input();
    EXPECT_EQ(program.line(), "");
    EXPECT_EQ(program.wait(), 0) << read("error");
    for (const char* name : {"trajectory.tum", "landmarks.json", "graph.g2o"}) {
      EXPECT_EQ(read_file(folder / "out" / name), read_file(folder / "file" / name)) << name;
    }
  }
}

// Whoever applies the lines has the map; numbers are those of events.jsonl.
TEST_F(StreamTest, LinesAddUpToTheMap) {
  const Ran ran =
      run_shell(HYBRID_BINARY_DIR "/bin/" + piped("--events") + " <" + kLog + " 2>" + at("error"));
  ASSERT_EQ(ran.code, 0);
  std::map<std::int64_t, Json> map;
  std::vector<Json> lines;
  std::istringstream text(ran.text);
  for (std::string line; std::getline(text, line);) {
    lines.push_back(Json::parse(line));
    for (const Json& id : lines.back()["removed"]) EXPECT_EQ(map.erase(id), 1U);
    for (const Json& landmark : lines.back()["changed"]) map[landmark["id"]] = landmark;
    EXPECT_EQ(lines.back()["landmarks"], map.size());
  }
  std::istringstream events(read("out/events.jsonl"));
  std::size_t keyframes = 0;
  for (std::string line; std::getline(events, line);) {
    const Json event = Json::parse(line);
    if (event["event"] != "keyframe") continue;
    for (const char* key : {"keyframe", "time", "pose", "landmarks", "objective", "cost"}) {
      EXPECT_EQ(lines.at(keyframes)[key], event[key]) << key;
    }
    ++keyframes;
  }
  EXPECT_EQ(keyframes, lines.size());
  const Json landmarks = Json::parse(read("out/landmarks.json"))["landmarks"];
  ASSERT_EQ(landmarks.size(), map.size());
  for (const Json& landmark : landmarks) {
    const Json& told = map.at(landmark["id"]);
    EXPECT_EQ(told["sightings"], landmark["sightings"]);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_NEAR(told["position"][axis], landmark["position"][axis], 0.01);
    }
  }
  EXPECT_NE(read("error").find("189 keyframes, 20 landmarks"), std::string::npos);
}

// It is asked each time the log has become longer by a fifth.
TEST_F(StreamTest, TellsTheAgreementOverTimeWhileTheLogRuns) {
  const Ran ran =
      run_shell(HYBRID_BINARY_DIR "/bin/" + piped() + " <" + kLog + " 2>" + at("error"));
  ASSERT_EQ(ran.code, 0);
  std::vector<double> times;
  Json last;
  double begin = 0;
  std::istringstream text(ran.text);
  for (std::string line; std::getline(text, line);) {
    const Json keyframe = Json::parse(line);
    if (keyframe["keyframe"] == 0) begin = keyframe["time"];
    if (!keyframe.contains("agreement")) continue;
    times.push_back(keyframe["time"].get<double>() - begin);
    last = keyframe["agreement"][0];
    EXPECT_EQ(last["name"], "agreement over time");
    EXPECT_EQ(last["verdict"], "good") << last;
  }
  ASSERT_GE(times.size(), 4U);
  EXPECT_GE(times.front(), 40);
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_GE(times[i], 1.2 * times[i - 1]);
  const Json health = Json::parse(read("out/summary.json"))["health"];
  const auto end = std::find_if(health.begin(), health.end(),
                                [&](const Json& entry) { return entry["name"] == last["name"]; });
  ASSERT_NE(end, health.end());
  EXPECT_NEAR((*end)["value"], last["value"].get<double>(), 0.05);
}

TEST_F(StreamTest, CutAndDamagedPipesAreUsedAsFilesAre) {
  const std::string whole = read_file(kLog);
  std::string flipped = whole;
  flipped[whole.size() * 2 / 3] ^= 0x10;
  for (const std::string& bytes : {whole.substr(0, whole.size() / 2), flipped}) {
    const Ran of_pipe = pipe_in(bytes);
    const auto summary = Json::parse(read("out/summary.json"));
    const auto of_file = summary_of(write("a.rawlog", bytes) + kSettings, 2);
    EXPECT_EQ(of_pipe.code, 2) << of_pipe.text;
    EXPECT_EQ(summary["status"], "partial");
    EXPECT_EQ(summary["keyframes"], of_file["keyframes"]);
    const std::string message = of_file["message"];
    EXPECT_EQ(summary["message"], "standard input" + message.substr(message.find(".rawlog") + 7));
    EXPECT_TRUE(summary["inputs"][0]["sha256"].is_null());
  }
  EXPECT_EQ(pipe_in("").text, "hybrid-replay: standard input: empty: the file holds nothing\n");
  const Ran text = pipe_in("time,x,y,yaw\n0,0,0,0\n");
  EXPECT_EQ(text.code, 1);
  EXPECT_EQ(text.text,
            "hybrid-replay: standard input: not a rawlog: this is a table: hybrid-import csv makes "
            "a rawlog of tables\n");
}

TEST_F(StreamTest, WhatWouldReadThePipeTwiceIsToldWhatToGive) {
  const auto fails = [&](const std::string& arguments, const std::string& part) {
    expect_failure("--rawlog - " + arguments + " <" + kLog, part);
  };
  fails("", "give [plugins] classes, such as BearingRangeKnownIds, and [map] dimension, 2 or 3");
  fails("--set map.dimension=2", "give [plugins] classes, such as BearingRangeKnownIds; auto");
  fails("--set plugins.classes=BearingRangeKnownIds", "give [map] dimension, 2 or 3; auto");
  fails(kSettings + " --frames 3", "--frames needs a file");
  fails(kSettings + " --resume --map " + at("a.hmap"), "--resume needs a file");
  const std::string map = " --map " + at("b.hmap");
  ASSERT_EQ(run_replay(kLog + kSettings + map + " -o " + at("first")).code, 0);
  fails(kSettings + map + " --map-mode localize", "give [map] start");
  const Ran ran =
      run_replay("--rawlog - " + kSettings + map +
                 " --map-mode localize --set 'map.start=0 0 0' -o " + at("second") + " <" + kLog);
  EXPECT_EQ(ran.code, 0) << ran.text;
}

TEST_F(StreamTest, ASignalEndsTheWaitForMore) {
  const std::vector<std::string> entries = entries_of_log();
  PipedProgram program(piped(), at("error"));
  for (int i = 0; i < 5; ++i) {
    program.write(entries[i]);
    ASSERT_NE(program.line(), "");
  }
  program.signal(SIGINT);
  EXPECT_EQ(program.line(), "");
  EXPECT_EQ(program.wait(), 130) << read("error");
  const auto summary = Json::parse(read("out/summary.json"));
  EXPECT_EQ(summary["status"], "interrupted");
  EXPECT_EQ(summary["message"], "stopped by SIGINT after 5 keyframes");
}

TEST_F(StreamTest, GoesOnWhenNobodyReadsItAnyMore) {
  const Ran ran = run_shell("{ " HYBRID_BINARY_DIR "/bin/" + piped() + " <" + kLog +
                            " 2>&1; echo $? >" + at("code") + "; } | head -n 1 >" + at("line"));
  EXPECT_EQ(Json::parse(read("line"))["keyframe"], 0);
  EXPECT_EQ(read("code"), "0\n");
  EXPECT_EQ(Json::parse(read("out/summary.json"))["keyframes"], 189);
}

}  // namespace
}  // namespace hybrid
