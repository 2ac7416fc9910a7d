// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/object_reader.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <memory>
#include <random>
#include <utility>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"

namespace hybrid {
namespace {

struct Outcome {
  LogStatus status = LogStatus::kReading;
  std::uint64_t objects = 0;
  std::string message;
  std::vector<std::string> notes;
};

Outcome read_all(const std::string& path) {
  ObjectReader reader(path);
  while (reader.next()) {
  }
  EXPECT_EQ(reader.progress(), std::make_optional(1.0));
  return {reader.status(), reader.objects(), reader.message(), reader.notes()};
}

Outcome read_bytes_as_log(const std::string& bytes) {
  const TemporaryFile file("bytes.rawlog");
  write_bytes(file.path(), bytes);
  return read_all(file.path());
}

void expect_mentions(const Outcome& outcome, const std::string& part) {
  EXPECT_NE(outcome.message.find(part), std::string::npos) << outcome.message;
}

std::string decompressed(const std::string& bytes) {
  return decode(bytes).bytes;
}

/// A log of 60 objects, compressed and not.
struct Sample {
  Sample() {
    const TemporaryFile file("sample.rawlog");
    Objects objects;
    for (int i = 0; i < 30; ++i) {
      objects.push_back(frame({observation(i)}));
      objects.push_back(motion_2d({1, 0.01 * i, 0.1}, 0.1));
    }
    write_log(file.path(), objects);
    compressed = read_bytes(file.path());
    plain = decompressed(compressed);
  }
  std::string compressed, plain;
};

TEST(ObjectReader, CompleteLogs) {
  const Sample sample;
  for (const std::string& bytes : {sample.compressed, sample.plain, zstd(sample.plain)}) {
    const Outcome outcome = read_bytes_as_log(bytes);
    EXPECT_EQ(outcome.status, LogStatus::kComplete);
    EXPECT_EQ(outcome.objects, 60U);
    EXPECT_EQ(outcome.message, "");
    EXPECT_TRUE(outcome.notes.empty());
  }
  const Outcome trailing = read_bytes_as_log(sample.compressed + "something else");
  EXPECT_EQ(trailing.status, LogStatus::kComplete);
  EXPECT_EQ(trailing.objects, 60U);
  EXPECT_EQ(trailing.notes.size(), 1U);
}

/// The same bytes of another content, with the time of the last change of before.
void overwrite_secretly(const std::string& path) {
  struct stat before {};
  ASSERT_EQ(::stat(path.c_str(), &before), 0);
  write_bytes(path, std::string(static_cast<std::size_t>(before.st_size), 'x'));
  const timespec times[] = {before.st_atim, before.st_mtim};
  ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times, 0), 0);
}

TEST(ObjectReader, ParsesALogOnceWhereItIsKept) {
  const TemporaryFile file("kept.rawlog");
  write_bytes(file.path(), Sample().compressed);
  LogRequest request;
  request.parsed = std::make_shared<ParsedLogs>();
  const auto read = [&](LogRequest wanted) {
    ObjectReader reader(file.path(), wanted);
    while (reader.next()) {
    }
    EXPECT_EQ(reader.progress(), std::make_optional(1.0));
    return std::make_pair(reader.status(), reader.objects());
  };
  const auto whole = std::make_pair(LogStatus::kComplete, std::uint64_t{60});
  ObjectReader given_up(file.path(), request);
  given_up.next();  // what was not read to its end is not kept
  EXPECT_EQ(read(request), whole);
  overwrite_secretly(file.path());
  EXPECT_EQ(read(request), whole);
  EXPECT_EQ(read({}).first, LogStatus::kNotARawlog);
  LogRequest other = request;
  other.points = true;
  EXPECT_EQ(read(other).first, LogStatus::kNotARawlog);
  write_bytes(file.path(), Sample().plain);  // another file of that name
  EXPECT_EQ(read(request), whole);
}

TEST(ParsedLogs, KeepNoMoreThanTheirBudget) {
  ParsedLog small(10);
  EXPECT_TRUE(small.add("0123456"));
  EXPECT_EQ(small.read(2), "23456");
  EXPECT_EQ(small.read(7), "");
  EXPECT_FALSE(small.add("7890"));
  EXPECT_FALSE(small.add("7"));
  EXPECT_EQ(ParsedLogs().begin(std::uint64_t{2} << 30), nullptr);
  EXPECT_EQ(ParsedLogs().find("log"), nullptr);
}

TEST(ParsedLogs, KeepLargeLogsInAFile) {
  const std::string block = "0123456789";
  ParsedLog large(std::uint64_t{1} << 24);
  std::string whole;
  for (std::size_t i = 0; i < 100; ++i) {
    std::string part;
    for (std::size_t k = 0; k < 10000 + i; ++k) part += block[(i + k) % 10];
    ASSERT_TRUE(large.add(part));
    whole += part;
    for (std::size_t k = 0; i % 20 == 0 && k < 10; ++k) {
      ASSERT_TRUE(large.add(std::string(100000, 'x')));
      whole += std::string(100000, 'x');
    }
  }
  ASSERT_EQ(large.size(), whole.size());
  ASSERT_GT(whole.size(), std::size_t{5} << 20);
  std::string back;
  for (std::string bytes; !(bytes = large.read(back.size())).empty();) back += bytes;
  EXPECT_TRUE(back == whole);
  EXPECT_FALSE(large.add(std::string(std::size_t{1} << 24, 'y')));
}

TEST(ObjectReader, MissingFilesAndFoldersThrow) {
  EXPECT_THROW(ObjectReader("no/such.rawlog"), Error);
  EXPECT_THROW(ObjectReader("/tmp"), Error);
  EXPECT_THROW(ObjectReader("/dev/zero"), Error);
  const TemporaryFile pipe("pipe.rawlog");
  ASSERT_EQ(mkfifo(pipe.path().c_str(), 0600), 0);
  EXPECT_THROW(ObjectReader(pipe.path()), Error) << "nobody writes into it: opening must not wait";
}

TEST(ObjectReader, EmptyAndForeignFiles) {
  EXPECT_EQ(read_bytes_as_log("").status, LogStatus::kEmpty);
  EXPECT_EQ(read_bytes_as_log(gzip("")).status, LogStatus::kEmpty);
  const Outcome text = read_bytes_as_log("[section]\nkey = value\n" + std::string(500, 'x'));
  EXPECT_EQ(text.status, LogStatus::kNotARawlog);
  EXPECT_EQ(text.objects, 0U);
  expect_mentions(text, "INI file");
  for (const std::string& graph : {std::string("VERTEX_SE2 0 0 0 0\n"), zstd("EDGE_SE2 0 1\n")}) {
    const Outcome outcome = read_bytes_as_log(graph);
    EXPECT_EQ(outcome.status, LogStatus::kNotARawlog);
    expect_mentions(outcome, "hybrid-pgo");
  }
  const Outcome noise =
      read_bytes_as_log(std::string("\x01\x02\x03\x04") + std::string(500, '\x05'));
  EXPECT_EQ(noise.status, LogStatus::kNotARawlog);
  expect_mentions(noise, "no MRPT object found");
}

TEST(ObjectReader, EveryTruncationIsNoticed) {
  const Sample sample;
  for (std::size_t size = 20; size < sample.compressed.size(); size += 29) {
    const Outcome outcome = read_bytes_as_log(sample.compressed.substr(0, size));
    EXPECT_EQ(outcome.status, LogStatus::kTruncated) << size << outcome.message;
    expect_mentions(outcome, "at object " + std::to_string(outcome.objects));
  }
  std::uint64_t most = 0;
  for (std::size_t size = 1; size < sample.plain.size(); size += 1999) {
    const Outcome outcome = read_bytes_as_log(sample.plain.substr(0, size));
    most = std::max(most, outcome.objects);
    if (outcome.objects == 0) continue;  // nothing tells a stump of one object from any other file
    EXPECT_NE(outcome.status, LogStatus::kNotARawlog) << size << outcome.message;
  }
  EXPECT_GT(most, 50U);
  const Outcome inside = read_bytes_as_log(sample.plain.substr(0, sample.plain.size() - 3));
  EXPECT_EQ(inside.status, LogStatus::kTruncated);
  EXPECT_EQ(inside.objects, 59U);
}

TEST(ObjectReader, EveryFlippedBitOfACompressedLogIsNoticed) {
  const Sample sample;
  std::mt19937 random(3);
  for (int trial = 0; trial < 60; ++trial) {
    std::string bytes = sample.compressed;
    // Behind the header, whose time stamp and system byte no checksum covers.
    const std::size_t at = 10 + random() % (bytes.size() - 10);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
    const Outcome outcome = read_bytes_as_log(bytes);
    if (outcome.status == LogStatus::kComplete) {
      // Some bits mean nothing: the content is whole.
      EXPECT_TRUE(decompressed(bytes) == sample.plain) << "byte " << at;
      continue;
    }
    EXPECT_NE(outcome.status, LogStatus::kReading) << "byte " << at;
    EXPECT_FALSE(outcome.message.empty());
  }
}

/// One kind of damage each.
std::string damaged(std::string bytes, int kind, std::mt19937& random) {
  const auto place = [&] { return random() % bytes.size(); };
  switch (kind) {
    case 0:
      for (int i = 0; i < 4; ++i) bytes[place()] = static_cast<char>(random());
      return bytes;
    case 1: {  // a length
      const std::size_t at = random() % (bytes.size() - 4);
      return bytes.replace(at, 4, std::string("\xf0\xff\xff\x7f", 4));
    }
    case 2:
      return bytes.erase(place(), 1 + random() % 300);
    default:
      return bytes.insert(place(), bytes.substr(place(), 1 + random() % 300));
  }
}

TEST(ObjectReader, DamageBehindARightChecksumNeverCrashes) {
  const Sample sample;
  std::mt19937 random(4);
  int noticed = 0;
  for (int trial = 0; trial < 80; ++trial) {
    const std::string bytes = damaged(sample.plain, trial % 4, random);
    const Outcome outcome = read_bytes_as_log(trial % 3 == 0   ? bytes
                                              : trial % 3 == 1 ? gzip(bytes)
                                                               : zstd(bytes));
    noticed += outcome.status != LogStatus::kComplete ? 1 : 0;
    EXPECT_EQ(outcome.status == LogStatus::kComplete, outcome.message.empty());
  }
  // Changed numbers are valid numbers: only a checksum could tell.
  EXPECT_GT(noticed, 40);
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(used.ru_maxrss, 1L << 20) << "KiB";
#endif
}

TEST(ObjectReader, DamagedCompressedBytesLoseWhatIsBehindThem) {
  const Sample sample;
  std::string bytes = sample.compressed;
  bytes[bytes.size() * 3 / 4] ^= 0x10;
  const Outcome outcome = read_bytes_as_log(bytes);
  EXPECT_EQ(outcome.status, LogStatus::kCorrupt) << outcome.message;
  EXPECT_GE(outcome.objects, 40U);
  expect_mentions(outcome, "may be damaged too");
}

TEST(ObjectReader, AByteThatSaysHowAMotionWasEstimated) {
  // MRPT takes what follows for an object of another kind, with a right checksum or without any.
  const Sample sample;
  const std::string name = "CActionRobotMovement2D";
  std::string bytes = sample.plain;
  std::size_t at = 0;
  for (int i = 0; i < 3; ++i) at = bytes.find(name, at) + name.size();
  for (const char method : {'\x2c', '\x9a', '\x00'}) {
    bytes[at + 1] = method;
    for (const std::string& log : {bytes, gzip(bytes), zstd(bytes)}) {
      const Outcome outcome = read_bytes_as_log(log);
      if (outcome.status == LogStatus::kComplete) continue;
      EXPECT_GE(outcome.objects, 5U) << outcome.message;
      EXPECT_LE(outcome.objects, 6U) << outcome.message;
    }
  }
}

TEST(ObjectReader, AHugeLengthTakesNoMemory) {
  const Sample sample;
  const std::string name = "CSensoryFrame";
  std::string bytes = sample.plain;
  const std::size_t count = bytes.find(name, bytes.size() / 2) + name.size() + 1;
  bytes.replace(count, 4, std::string("\xff\xff\xff\x7f", 4));
  const Outcome outcome = read_bytes_as_log(gzip(bytes));
  EXPECT_GT(outcome.objects, 20U);
#ifndef __SANITIZE_ADDRESS__
  EXPECT_EQ(outcome.status, LogStatus::kTooLarge) << outcome.message;
  expect_mentions(outcome, "MB");
  expect_mentions(outcome, name);
#endif
}

TEST(ObjectReader, BombsAreNamed) {
  const Sample sample;
  for (const std::string& bomb : {gzip(sample.plain + std::string(std::size_t{1} << 26, '\0')),
                                  zstd(std::string(std::size_t{1} << 27, '\x88'))}) {
    const Outcome outcome = read_bytes_as_log(bomb);
    EXPECT_NE(outcome.status, LogStatus::kComplete);
    EXPECT_FALSE(outcome.message.empty());
  }
  // Many sound objects that compress well.
  auto alike = std::make_shared<mrpt::obs::CObservationBearingRange>();
  alike->sensedData.resize(20'000, {1, 0, 0, mrpt::obs::INVALID_LANDMARK_ID, {}});
  const TemporaryFile file("alike.rawlog");
  write_log(file.path(), {alike});
  const std::string one = decompressed(read_bytes(file.path()));
  std::string many;
  for (int i = 0; i < 150; ++i) many += one;
  const Outcome outcome = read_bytes_as_log(gzip(many, 9));
  EXPECT_EQ(outcome.status, LogStatus::kTooLarge) << outcome.message;
  EXPECT_GT(outcome.objects, 90U);
  expect_mentions(outcome, "100 times its size");
}

TEST(ObjectReader, AnActionWithAForeignObjectInsideDoesNotCrash) {
  // The distribution inside an action replaced by another class: MRPT does not check it.
  const Sample sample;
  std::string bytes = sample.plain;
  const std::string inside = "CPosePDFGaussian", other = "CSensoryFrame";
  for (std::size_t at = bytes.find(inside); at != std::string::npos; at = bytes.find(inside)) {
    bytes[at - 1] = static_cast<char>(0x80 | other.size());
    bytes.replace(at, inside.size(), other);
  }
  const Outcome outcome = read_bytes_as_log(bytes);
  EXPECT_EQ(outcome.status, LogStatus::kCorrupt) << outcome.message;
  EXPECT_EQ(outcome.objects, 1U);
  EXPECT_EQ(read_bytes_as_log(gzip(bytes)).message.substr(20), outcome.message.substr(20));
}

TEST(ObjectReader, UnregisteredClassNamesThePluginOption) {
  const Sample sample;
  std::string bytes = sample.plain;
  const std::string known = "CSensoryFrame", unknown = "CUnheardFrame";
  bytes.replace(bytes.rfind(known), known.size(), unknown);
  const Outcome outcome = read_bytes_as_log(bytes);
  EXPECT_EQ(outcome.status, LogStatus::kUnregisteredClass);
  EXPECT_EQ(outcome.objects, 58U);
  expect_mentions(outcome, "CUnheardFrame' is not known");
  expect_mentions(outcome, "-p");
}

TEST(ObjectReader, PointsOfScansAndMapsWhereAskedFor) {
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  scan->aperture = static_cast<float>(M_PI);
  scan->resizeScanAndAssign(5, 2.0F, true);
  auto map = std::make_shared<mrpt::maps::CSimplePointsMap>();
  map->insertPoint(1, 2, 3);
  const TemporaryFile file("points.rawlog");
  write_log(file.path(), {frame({scan, observation(1)}), scan, map});
  LogRequest request;
  request.points = true;
  ObjectReader reader(file.path(), request);
  const auto sensed = reader.next(), alone = reader.next(), points = reader.next();
  ASSERT_TRUE(sensed && alone && points && !reader.next());
  EXPECT_EQ(std::get<LoggedFrame>(*sensed).observations.at(0).points.size(), 5U);
  EXPECT_TRUE(std::get<LoggedFrame>(*sensed).observations.at(1).points.empty());
  EXPECT_EQ(std::get<LoggedObservation>(*alone).points.size(), 5U);
  EXPECT_TRUE(std::get<LoggedObservation>(*alone).content);
  EXPECT_EQ(std::get<LoggedPoints>(*points).points.at(0).z, 3);

  ObjectReader plain(file.path());
  EXPECT_TRUE(std::get<LoggedFrame>(*plain.next()).observations.at(0).points.empty());
  plain.next();
  EXPECT_NE(std::get<OtherObject>(*plain.next()).class_name.find("CSimplePointsMap"),
            std::string::npos);
}

}  // namespace
}  // namespace hybrid
