// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Runs docs/tries.md: every `$ command` of its indented blocks, and compares the answers.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

struct Try {
  std::string command;
  std::vector<std::string> answer;
  int code = 0;  ///< "[exit N]" ends an answer that is not 0
};

std::vector<Try> tries_of(const std::string& page) {
  std::vector<Try> tries;
  std::ifstream lines(page);
  const std::string exit_mark = "[exit ";
  bool in_block = false;
  for (std::string line; std::getline(lines, line);) {
    const bool indented = line.rfind("    ", 0) == 0;
    if (indented) line.erase(0, 4);
    if (indented && line.rfind("$ ", 0) == 0) {
      tries.push_back({line.substr(2), {}, 0});
    } else if (indented && in_block && line.rfind(exit_mark, 0) == 0) {
      tries.back().code = std::stoi(line.substr(exit_mark.size()));
    } else if (indented && in_block) {
      tries.back().answer.push_back(line);
    }
    in_block = indented && !tries.empty();
  }
  return tries;
}

/// Whether the text is the pattern, in which "..." stands for anything.
bool matches(const std::string& text, const std::string& pattern) {
  std::size_t at = 0, from = 0;
  for (bool first = true;; first = false) {
    const std::size_t dots = pattern.find("...", from);
    const std::string part = pattern.substr(from, dots - from);
    if (dots == std::string::npos && !first) {
      return text.size() >= at + part.size() &&
             text.compare(text.size() - part.size(), part.size(), part) == 0;
    }
    if (dots == std::string::npos) return text == part;
    const std::size_t found =
        first ? (text.rfind(part, 0) == 0 ? 0 : std::string::npos) : text.find(part, at);
    if (found == std::string::npos) return false;
    at = found + part.size();
    from = dots + 3;
  }
}

TEST(MatchesPattern, DotsStandForAnything) {
  EXPECT_TRUE(matches("abc", "abc"));
  EXPECT_TRUE(matches("abc", "a...c"));
  EXPECT_TRUE(matches("abc", "...bc..."));
  EXPECT_TRUE(matches("abcabc", "a...c...bc"));
  EXPECT_FALSE(matches("abc", "ab"));
  EXPECT_FALSE(matches("abc", "b...c"));
  EXPECT_FALSE(matches("abc", "a...c...c"));
}

using Tries = ScratchFolder;

TEST_F(Tries, AnswerAsThePageSays) {
  for (const char* name : {"config", "rawlogs"}) {
    std::filesystem::create_directory_symlink(std::string(HYBRID_SOURCE_DIR "/") + name, at(name));
  }
  const std::vector<Try> tries = tries_of(HYBRID_SOURCE_DIR "/docs/tries.md");
  EXPECT_GT(tries.size(), 50U);
  for (const Try& one : tries) {
    const Ran ran =
        run_shell("cd " + folder.string() + " && PATH=" HYBRID_BINARY_DIR "/bin:$PATH && { " +
                  one.command + "; } 2>&1");
    EXPECT_EQ(ran.code, one.code) << one.command << "\n" << ran.text;
    std::vector<std::string> said;
    for (std::size_t at = 0; at < ran.text.size();) {
      const std::size_t end = std::min(ran.text.find('\n', at), ran.text.size());
      said.push_back(ran.text.substr(at, end - at));
      at = end + 1;
    }
    ASSERT_EQ(said.size(), one.answer.size()) << one.command << "\n" << ran.text;
    for (std::size_t i = 0; i < said.size(); ++i) {
      EXPECT_TRUE(matches(said[i], one.answer[i]))
          << one.command << "\n says " << said[i] << "\n not  " << one.answer[i];
    }
  }
}

}  // namespace
}  // namespace hybrid
