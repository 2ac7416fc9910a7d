// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

TEST(WriteFile, ReplacesWholeFilesOrNothing) {
  const fs::path folder = fs::path(::testing::TempDir()) / "write_file_test";
  fs::remove_all(folder);
  EXPECT_THROW(write_file(folder / "a", "1"), Error);  // no such folder
  fs::create_directories(folder / "taken" / "inside");
  write_file(folder / "a", "first");
  write_file(folder / "a", std::string_view("two\0three", 9));
  std::ifstream file(folder / "a", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text, std::string("two\0three", 9));
  EXPECT_THROW(write_file(folder / "taken", "1"), Error);
  EXPECT_TRUE(fs::exists(folder / "taken" / "inside"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);  // nothing temporary is left
  fs::remove_all(folder);
}

}  // namespace
}  // namespace hybrid
