// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace hybrid {

/// A fixture with an empty folder, removed at the end of the test.
class ScratchFolder : public ::testing::Test {
 protected:
  ScratchFolder() { std::filesystem::create_directories(folder); }
  ~ScratchFolder() override { std::filesystem::remove_all(folder); }

  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return at(name);
  }
  std::string read(const std::string& name) const {
    std::ifstream in(folder / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("hybrid_test_" + std::to_string(getpid()));
};

}  // namespace hybrid
