// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>

namespace hybrid {

/// Rows of the text of a results.csv without the columns of times, by the key of the trial.
inline std::map<std::string, std::string> trial_rows(const std::string& results) {
  std::map<std::string, std::string> rows;
  std::istringstream lines(results);
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    std::string cell, kept;
    for (int c = 0; std::getline(cells, cell, ','); ++c) {
      if (c != 7 && c != 8) kept += cell + ",";
    }
    EXPECT_TRUE(rows.emplace(line.substr(0, line.find(',')), kept).second) << line;
  }
  return rows;
}

}  // namespace hybrid
