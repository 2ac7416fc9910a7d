// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/output_directory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace hybrid {
namespace {

namespace fs = std::filesystem;

class OutputDirectoryTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(root_); }
  void TearDown() override { fs::remove_all(root_); }

  static std::string content(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  static std::size_t entries(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }

  const fs::path root_ =
      fs::temp_directory_path() / ("output_directory_test_" + std::to_string(::getpid()) + "_" +
                                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(OutputDirectoryTest, CreatesNestedFoldersAndLeavesNothingElse) {
  const OutputDirectory out(root_ / "a" / "b");
  EXPECT_EQ(entries(root_ / "a" / "b"), 0u);
  const std::string bytes("x\0y\n", 4);
  out.write("data.bin", bytes);
  EXPECT_EQ(content(root_ / "a" / "b" / "data.bin"), bytes);
  EXPECT_EQ(entries(root_ / "a" / "b"), 1u);
}

TEST_F(OutputDirectoryTest, ReplacesAnOlderFile) {
  const OutputDirectory out(root_);
  out.write("f.txt", "a long first version");
  out.write("f.txt", "second");
  EXPECT_EQ(content(root_ / "f.txt"), "second");
}

TEST_F(OutputDirectoryTest, AFailedWriterLeavesTheOlderFileAndNoRest) {
  const OutputDirectory out(root_);
  out.write("f.txt", "old");
  const auto half = [](const std::string& path) {
    std::ofstream(path) << "half";
    throw std::runtime_error("disk on fire");
  };
  try {
    out.save("f.txt", half);
    FAIL() << "no error";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("f.txt"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("disk on fire"), std::string::npos) << e.what();
  }
  EXPECT_EQ(content(root_ / "f.txt"), "old");
  EXPECT_EQ(entries(root_), 1u);
}

TEST_F(OutputDirectoryTest, TheTemporaryNameKeepsTheExtensionAndTheFolder) {
  const OutputDirectory out(root_);
  out.save("p.png", [this](const std::string& path) {
    EXPECT_EQ(fs::path(path).extension(), ".png");
    EXPECT_EQ(fs::path(path).parent_path(), root_);
    EXPECT_FALSE(fs::exists(root_ / "p.png"));
    std::ofstream(path) << "x";
  });
  EXPECT_TRUE(fs::exists(root_ / "p.png"));
}

TEST_F(OutputDirectoryTest, AWriterThatWritesNothingIsAnError) {
  const OutputDirectory out(root_);
  EXPECT_THROW(out.save("f.txt", [](const std::string&) {}), std::runtime_error);
}

TEST_F(OutputDirectoryTest, AFullDiskIsAnErrorThatLeavesNothing) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const OutputDirectory out(root_);
  const auto onto_full_device = [](const std::string& path) {
    fs::create_symlink("/dev/full", path);
    std::ofstream file(path);
    file << std::string(1 << 20, 'x');
    if (!file.flush()) throw std::runtime_error("no space");
  };
  EXPECT_THROW(out.save("f.txt", onto_full_device), std::runtime_error);
  EXPECT_EQ(entries(root_), 0u);
}

TEST_F(OutputDirectoryTest, RefusesNamesThatLeaveTheFolder) {
  const OutputDirectory out(root_);
  for (const char* name : {"", ".", "..", "../f", "sub/f", "/f"}) {
    EXPECT_THROW(out.write(name, "x"), std::runtime_error) << name;
  }
}

TEST_F(OutputDirectoryTest, AFileInTheWayIsNamed) {
  fs::create_directories(root_);
  std::ofstream(root_ / "file") << "x";
  for (const fs::path& bad : {root_ / "file", root_ / "file" / "sub", fs::path("/proc/hybrid")}) {
    try {
      const OutputDirectory out(bad);
      FAIL() << bad;
    } catch (const std::runtime_error& e) {
      EXPECT_NE(std::string(e.what()).find(bad.string()), std::string::npos) << e.what();
    }
  }
}

TEST_F(OutputDirectoryTest, ATargetThatIsAFolderIsAnErrorThatLeavesNoRest) {
  const OutputDirectory out(root_);
  fs::create_directories(root_ / "f.txt" / "inner");
  EXPECT_THROW(out.write("f.txt", "x"), std::runtime_error);
  EXPECT_EQ(entries(root_), 1u);
}

}  // namespace
}  // namespace hybrid
