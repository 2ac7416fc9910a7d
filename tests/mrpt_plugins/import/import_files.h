// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {

/// The files an importer reads and writes.
class ImportTest : public ScratchFolder {
 protected:
  ImportTest() {
    watch_steps([this](const ImportProgress& so_far) {
      if (so_far.steps == 1) shares_.clear();
      shares_.push_back(so_far.share);
    });
  }
  ~ImportTest() override { watch_steps({}); }

  /// Expects that the last import told at each of its steps how much of the input it had used.
  void expect_progress(std::size_t count, double end = 1) const {
    ASSERT_EQ(shares_.size(), count);
    EXPECT_GE(shares_.front(), 0);
    EXPECT_LT(shares_.front(), end);
    EXPECT_TRUE(std::is_sorted(shares_.begin(), shares_.end()));
    EXPECT_NEAR(shares_.back(), end, 1e-9);
  }

  std::string log() const { return at("out.rawlog"); }

  std::vector<LogStep> steps() const {
    RawlogReader reader(log());
    std::vector<LogStep> all;
    while (auto step = reader.next()) all.push_back(std::move(*step));
    EXPECT_EQ(reader.status(), LogStatus::kComplete) << reader.message();
    return all;
  }

  static const CObservationClassedBearingRange& seen(const LogStep& step) {
    return dynamic_cast<const CObservationClassedBearingRange&>(*step.observations.at(0));
  }

  /// Number of remarks that hold `part`.
  static std::ptrdiff_t count_notes(const ImportReport& report, const std::string& part) {
    return std::count_if(report.notes.begin(), report.notes.end(), [&](const std::string& note) {
      return note.find(part) != std::string::npos;
    });
  }
  static bool tells(const ImportReport& report, const std::string& part) {
    return count_notes(report, part) > 0;
  }

  /// Expects an Error whose text holds `part`, and no log.
  template <class Import>
  void expect_error(Import import, const std::string& part) const {
    try {
      import();
      FAIL() << "no error";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
    EXPECT_FALSE(std::filesystem::exists(log()));
    EXPECT_FALSE(std::filesystem::exists(log() + ".part"));
  }

 private:
  std::vector<double> shares_;  // of the input, at each step of the last import
};

}  // namespace hybrid
