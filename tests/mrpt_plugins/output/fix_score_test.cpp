// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/output/mode_writer.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

constexpr auto kGoodFix = FixMode::kGood, kBiasedFix = FixMode::kBiased,
               kFalseFix = FixMode::kFalse;

FixEstimate judged_fix(double time, const std::array<double, 3>& probabilities) {
  FixEstimate fix;
  fix.time = time;
  fix.probabilities = probabilities;
  fix.mode = kGoodFix;  // the probabilities count
  return fix;
}

TEST(FixScore, CountsFalseAndBiasedOnes) {
  const FixScore s = score_fixes({judged_fix(1, {0.9, 0.1, 0}), judged_fix(2, {0.2, 0.7, 0.1}),
                                  judged_fix(3, {0, 0.25, 0.75})},
                                 {{1, kGoodFix}, {2, kBiasedFix}, {3, kBiasedFix}});
  EXPECT_EQ(s.fixes, 3U);
  EXPECT_EQ(s.wrong.found, 1U);
  EXPECT_EQ(s.wrong.real, 0U);
  EXPECT_DOUBLE_EQ(s.wrong.precision(), 0);
  EXPECT_DOUBLE_EQ(s.wrong.recall(), 1);  // of none
  EXPECT_DOUBLE_EQ(s.biased.precision(), 1);
  EXPECT_DOUBLE_EQ(s.biased.recall(), 0.5);
  // By bins of a tenth: 0.1 and 0.1 come true never, 0.2 and 0.25 once, 0.7 and 0.75 once, 0.9
  // once.
  EXPECT_NEAR(*s.calibration_error, (0.2 + 0.55 + 0.45 + 0.1) / 9, 1e-12);
}

TEST(FixScore, RowsAreFoundByTimeAndOrder) {
  // Rows lack the fix at 2; fixes lack the row at 3; two fixes are at 4, and none is at 5.
  const FixScore s = score_fixes({judged_fix(4.0001, {0, 0, 1}), judged_fix(1, {0, 0, 1}),
                                  judged_fix(2, {0, 0, 1}), judged_fix(4.0001, {1, 0, 0})},
                                 {{0, kGoodFix},
                                  {1, kFalseFix},
                                  {3, kGoodFix},
                                  {4, kFalseFix},
                                  {4, kGoodFix},
                                  {5, kFalseFix}});
  EXPECT_EQ(s.fixes, 3U);
  EXPECT_EQ(s.wrong.real, 2U);
  EXPECT_EQ(s.wrong.both, 2U);
  EXPECT_NEAR(*s.calibration_error, 0, 1e-12);
}

TEST(FixScore, WithoutProbabilitiesTheModeCounts) {
  FixEstimate plain, left_out, waiting;
  plain.time = 1;
  plain.mode = kGoodFix;
  left_out.time = 2;
  left_out.unused = "farther off than a gate";
  waiting.time = 3;
  const FixScore s =
      score_fixes({plain, left_out, waiting}, {{1, kFalseFix}, {2, kFalseFix}, {3, kFalseFix}});
  EXPECT_EQ(s.fixes, 2U);
  EXPECT_DOUBLE_EQ(s.wrong.precision(), 1);
  EXPECT_DOUBLE_EQ(s.wrong.recall(), 0.5);
  EXPECT_FALSE(s.calibration_error);
}

TEST(TrueFixes, AreSortedByTimeAndBadRowsNamed) {
  const TemporaryFile file("true_fixes.csv");
  const std::string titles = "time,mode,error_east,error_north,error_up\n";
  write_bytes(file.path(), titles + "2,biased,1,2,3\n1,good,0,0,0\n3,false,9,9,9\n");
  const auto rows = read_true_fixes(file.path());
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].mode, kGoodFix);
  EXPECT_EQ(rows[1].mode, kBiasedFix);
  EXPECT_EQ(rows[2].mode, kFalseFix);
  const auto message = [&](const std::string& text) -> std::string {
    write_bytes(file.path(), text);
    try {
      read_true_fixes(file.path());
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message(titles + "1,wrong,0,0,0\n")
                .find(":2:3: 'wrong' is no mode of a fix; write one "
                      "of good, biased, false"),
            std::string::npos);
  EXPECT_NE(message(titles + "1,good,0,0\n").find(":2:"), std::string::npos);
  EXPECT_NE(message(titles + "1,good,0,x,0\n").find(":2:10"), std::string::npos);
  EXPECT_NE(message(titles).find("no row of a fix"), std::string::npos);
}

}  // namespace
}  // namespace hybrid
