// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"

namespace hybrid {
namespace {

/// Text that compresses to about a third.
std::string sample(std::size_t size, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::string text;
  while (text.size() < size) text += std::to_string(random() % 100000) + " and ";
  text.resize(size);
  return text;
}

using Compress = std::string (*)(const std::string&);
constexpr Compress kMethods[] = {[](const std::string& bytes) { return bytes; },
                                 [](const std::string& bytes) { return gzip(bytes); },
                                 [](const std::string& bytes) { return zstd(bytes); }};

TEST(Decoder, GivesBackWhatWasCompressed) {
  for (const std::size_t size : {1UL, 5UL, 1000UL, 400'000UL}) {
    for (const Compress compress : kMethods) {
      for (const std::size_t portion : {1UL, 999UL, 1UL << 20}) {
        if (portion == 1 && size > 1000) continue;
        const Decoded out = decode(compress(sample(size)), {}, portion);
        EXPECT_TRUE(out.bytes == sample(size)) << size;
        EXPECT_EQ(out.end, DecodeEnd::kSound) << out.message;
        EXPECT_FALSE(out.has_trailing_bytes);
      }
    }
  }
  EXPECT_EQ(decode("").end, DecodeEnd::kSound);
  EXPECT_EQ(decode(gzip("")).bytes, "");
}

TEST(Decoder, MembersOneAfterTheOtherAreOneStream) {
  const std::string a = sample(70'000, 1), b = sample(100, 2);
  EXPECT_EQ(decode(gzip(a) + gzip("") + gzip(b)).bytes, a + b);
  EXPECT_EQ(decode(zstd(a) + zstd(b)).bytes, a + b);
  const std::string skippable("\x50\x2a\x4d\x18\x03\x00\x00\x00xyz", 11);
  EXPECT_EQ(decode(zstd(a) + skippable + zstd(b)).bytes, a + b);
  EXPECT_EQ(decode(skippable + zstd(b)).bytes, b);
}

TEST(Decoder, GivesAllThatHasComeBeforeItAsksForMore) {
  const std::string all[] = {sample(300, 1), sample(400'000, 2), std::string(300'000, 'x')};
  for (const Compress compress : kMethods) {
    std::string there = compress(all[0]);
    Decoder decoder([&](char* to, std::size_t count) {
      if (there.empty()) throw std::logic_error("a slow writer would be waited for");
      const std::size_t given = there.copy(to, count);
      there.erase(0, given);
      return given;
    });
    for (const std::string& sent : all) {
      if (&sent != all) there = compress(sent);
      std::string got(sent.size(), '\0');
      for (std::size_t size = 0; size < got.size();) {
        const std::size_t portion = std::min<std::size_t>(1000, got.size() - size);
        size += decoder.read(got.data() + size, portion);
      }
      EXPECT_TRUE(got == sent) << sent.size();
    }
  }
}

TEST(Decoder, BytesBehindTheLastMemberAreLeftOut) {
  for (const std::string& behind : {std::string(1000, '\0'), std::string("x"), sample(9000)}) {
    for (const std::string& stream : {gzip(sample(5000)), zstd(sample(5000))}) {
      const Decoded out = decode(stream + behind);
      EXPECT_EQ(out.bytes, sample(5000));
      EXPECT_EQ(out.end, DecodeEnd::kSound);
      EXPECT_TRUE(out.has_trailing_bytes);
    }
  }
}

TEST(Decoder, WhatWasCutOffIsDecodedUpToTheCut) {
  const std::string whole = sample(400'000);
  for (const Compress compress : {kMethods[1], kMethods[2]}) {
    const std::string stream = compress(whole);
    for (std::size_t size = 5; size < stream.size(); size += stream.size() / 40) {
      const Decoded out = decode(stream.substr(0, size));
      EXPECT_EQ(out.end, DecodeEnd::kTruncated) << size;
      EXPECT_EQ(out.bytes, whole.substr(0, out.bytes.size())) << size;
      // Zstandard comes in blocks of 128 KiB.
      EXPECT_GT(out.bytes.size() + (1U << 17), size * whole.size() / stream.size() * 9 / 10);
    }
  }
}

TEST(Decoder, ADamagedByteLosesOnlyWhatIsBehindIt) {
  const std::string whole = sample(200'000);
  std::string stream = gzip(whole);
  std::mt19937 random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const std::size_t at = stream.size() / 4 + random() % (stream.size() / 2);
    std::string damaged = stream;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << (random() % 8)));
    const Decoded out = decode(damaged);
    EXPECT_EQ(out.end, DecodeEnd::kDamaged) << at;
    EXPECT_NE(out.message.find("damaged"), std::string::npos);
    std::size_t right = 0;
    while (right < out.bytes.size() && out.bytes[right] == whole[right]) ++right;
    EXPECT_GT(right, at * whole.size() / stream.size() * 9 / 10) << at;
  }
  std::string checksum = zstd(whole);
  checksum.back() = static_cast<char>(checksum.back() ^ 1);
  EXPECT_EQ(decode(checksum).end, DecodeEnd::kDamaged);
}

TEST(Decoder, BombsEndAtTheLimit) {
  const std::string zeros(std::size_t{1} << 24, '\0');
  const InflationLimit limit{1U << 20, 100};
  for (const std::string& bomb : {gzip(zeros), zstd(zeros)}) {
    const Decoded out = decode(bomb, limit);
    EXPECT_EQ(out.end, DecodeEnd::kTooLarge);
    EXPECT_LE(out.bytes.size(), limit.free_bytes + limit.ratio * bomb.size() + 1000);
    EXPECT_NE(out.message.find("100 times"), std::string::npos) << out.message;
  }
  EXPECT_EQ(decode(gzip(zeros), {1U << 25, 100}).end, DecodeEnd::kSound);
  EXPECT_EQ(decode(zeros, {0, 0}).end, DecodeEnd::kSound) << "a plain file does not grow";
}

TEST(Decoder, AFrameThatWantsAHugeWindowIsRefused) {
  // A frame header that asks for a window of 2 GiB.
  const std::string frame("\x28\xb5\x2f\xfd\x00\xa8\x01\x00\x00", 9);
  const Decoded out = decode(frame + sample(1000));
  EXPECT_EQ(out.end, DecodeEnd::kDamaged);
  EXPECT_NE(out.message.find("too much memory"), std::string::npos) << out.message;
}

TEST(Decoder, AnyBytesEndSomehow) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes = kMethods[1 + trial % 2](sample(random() % 3000));
    for (int i = 0; i < 3; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    EXPECT_NE(decode(bytes, {1U << 20, 10}).end, DecodeEnd::kNone);
  }
}

TEST(Decoder, AFileIsCheckedToItsEnd) {
  const TemporaryFile file("checked");
  write_bytes(file.path(), gzip(sample(300'000)));
  EXPECT_EQ(decoding_fault(file.path()), "");
  write_bytes(file.path(), gzip(sample(300'000)).substr(0, 50'000));
  EXPECT_EQ(decoding_fault(file.path()), "the compressed file ends early");
}

}  // namespace
}  // namespace hybrid
