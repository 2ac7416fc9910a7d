// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/object_reader.h"

#include <gtest/gtest.h>

#include <random>

#include "libhybrid/core/error.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

struct Outcome {
  LogStatus status = LogStatus::kReading;
  std::uint64_t objects = 0;
  std::string message;
};

Outcome read_all(const std::string& path) {
  ObjectReader reader(path);
  while (reader.next()) {
  }
  EXPECT_EQ(reader.progress(), 1.0);
  return {reader.status(), reader.objects(), reader.message()};
}

Outcome read_bytes_as_log(const std::string& bytes) {
  const TemporaryFile file("bytes.rawlog");
  write_bytes(file.path(), bytes);
  return read_all(file.path());
}

void expect_mentions(const Outcome& outcome, const std::string& part) {
  EXPECT_NE(outcome.message.find(part), std::string::npos) << outcome.message;
}

std::string decompressed(const std::string& compressed) {
  const TemporaryFile file("compressed");
  write_bytes(file.path(), compressed);
  std::string bytes(check_gzip(file.path()).bytes, ' ');
  EXPECT_EQ(GzipStream(file.path()).Read(bytes.data(), bytes.size()), bytes.size());
  return bytes;
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
  for (const std::string* bytes : {&sample.compressed, &sample.plain}) {
    const Outcome outcome = read_bytes_as_log(*bytes);
    EXPECT_EQ(outcome.status, LogStatus::kComplete);
    EXPECT_EQ(outcome.objects, 60U);
    EXPECT_EQ(outcome.message, "");
  }
}

TEST(ObjectReader, MissingFilesAndFoldersThrow) {
  EXPECT_THROW(ObjectReader("no/such.rawlog"), Error);
  EXPECT_THROW(ObjectReader("/tmp"), Error);
}

TEST(ObjectReader, EmptyAndForeignFiles) {
  EXPECT_EQ(read_bytes_as_log("").status, LogStatus::kEmpty);
  const Outcome text = read_bytes_as_log("[section]\nkey = value\n" + std::string(500, 'x'));
  EXPECT_EQ(text.status, LogStatus::kNotARawlog);
  EXPECT_EQ(text.objects, 0U);
  expect_mentions(text, "no MRPT object found");
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

TEST(ObjectReader, DamagedPlainLogsNeverCrash) {
  const Sample sample;
  std::mt19937 random(4);
  int noticed = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::string bytes = sample.plain;
    for (int i = 0; i < 4; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    noticed += read_bytes_as_log(bytes).status != LogStatus::kComplete ? 1 : 0;
  }
  // Changed numbers are valid numbers: only a checksum could tell.
  EXPECT_GT(noticed, 15);
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

}  // namespace
}  // namespace hybrid
