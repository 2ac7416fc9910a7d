// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_file.h"

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class WriteFile : public ScratchFolder {};

TEST_F(WriteFile, ReplacesWholeFilesOrNothing) {
  fs::create_directories(folder / "taken" / "inside");
  write_file(at("a"), "first");
  write_file(at("a"), std::string_view("two\0three", 9));
  EXPECT_EQ(read("a"), std::string("two\0three", 9));
  EXPECT_THROW(write_file(at("taken"), "1"), Error);
  EXPECT_THROW(write_file(at("a/b"), "1"), Error);    // a file is no folder
  EXPECT_THROW(write_file(at("new/b"), "1"), Error);  // no such folder
  EXPECT_TRUE(fs::exists(folder / "taken" / "inside"));
  EXPECT_EQ(entries_of(folder).size(), 2U);  // nothing temporary is left
}

}  // namespace
}  // namespace hybrid
