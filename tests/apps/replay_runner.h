// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

namespace hybrid {

struct Ran {
  int code = -1;     ///< 128 + signal if it crashed
  std::string text;  ///< standard output and error
};

inline Ran run_app(const std::string& command) {
  Ran ran;
  FILE* pipe = popen((HYBRID_BINARY_DIR "/bin/" + command + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) ran.text += buffer.data();
  const int status = pclose(pipe);
  ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ran;
}

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

/// A folder of its own for each test.
class ReplayTest : public testing::Test {
 protected:
  ReplayTest() { std::filesystem::create_directories(folder); }
  ~ReplayTest() override { std::filesystem::remove_all(folder); }

  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return at(name);
  }
  /// Replays into folder/out without pictures and returns the summary.
  nlohmann::json summary_of(const std::string& arguments, int expected_code = 0) const {
    const Ran ran = run_replay(arguments + " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, expected_code) << ran.text;
    const std::string text = read_file(folder / "out" / "summary.json");
    return nlohmann::json::parse(text.empty() ? "{}" : text);
  }
  /// Expects exit code 1, a message of one line that holds `part`, and no output.
  void expect_failure(const std::string& arguments, const std::string& part) const {
    const Ran ran = run_replay(arguments + " --no-pictures -o " + at("out"));
    EXPECT_EQ(ran.code, 1) << arguments << "\n" << ran.text;
    EXPECT_NE(ran.text.find(part), std::string::npos) << ran.text;
    EXPECT_EQ(ran.text.find('\n'), ran.text.size() - 1) << ran.text;
    EXPECT_FALSE(std::filesystem::exists(folder / "out" / "summary.json"));
  }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("hybrid_replay_" + std::to_string(getpid()));
};

}  // namespace hybrid
