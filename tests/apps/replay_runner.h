// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {

inline Ran run_replay(const std::string& arguments) {
  return run_app("hybrid-replay " + arguments);
}

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline std::string config(const std::string& name) {
  return std::string(HYBRID_SOURCE_DIR "/config/") + name;
}

class ReplayTest : public ScratchFolder {
 protected:
  /// Replays into folder/out without pictures and returns the summary.
  nlohmann::json summary_of(const std::string& arguments, int expected_code = 0) const {
    const Ran ran = run_replay(arguments + " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, expected_code) << ran.text;
    const std::string text = read_file(folder / "out" / "summary.json");
    return nlohmann::json::parse(text.empty() ? "{}" : text);
  }
  /// The entry of that name of the health in a summary; null if there is none.
  static nlohmann::json entry(const nlohmann::json& summary, const std::string& name) {
    for (const nlohmann::json& e : summary.at("health")) {
      if (e.at("name") == name) return e;
    }
    return {};
  }
  /// Expects exit code 1, a message of one line that holds `part`, and no output.
  void expect_failure(const std::string& arguments, const std::string& part) const {
    const Ran ran = run_replay(arguments + " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, 1) << arguments << "\n" << ran.text;
    EXPECT_NE(ran.text.find(part), std::string::npos) << ran.text;
    EXPECT_EQ(ran.text.find('\n'), ran.text.size() - 1) << ran.text;
    EXPECT_FALSE(std::filesystem::exists(folder / "out" / "summary.json"));
  }
};

}  // namespace hybrid
