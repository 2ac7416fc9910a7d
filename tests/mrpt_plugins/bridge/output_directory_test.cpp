// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/output_directory.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "mrpt_plugins/bridge/sha256.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

class OutputDirectoryTest : public ScratchFolder {
 protected:
  const fs::path out_ = folder / "a" / "out";

  /// Files of the output folder but summary.json.
  Files files() const {
    Files found;
    for (const std::string& name : files_below(out_)) {
      if (name != "summary.json") found[name] = read("a/out/" + name);
    }
    return found;
  }
  nlohmann::json summary() const { return nlohmann::json::parse(read("a/out/summary.json")); }
  /// Writes a result; returns what is to be told.
  std::vector<std::string> publish(const Files& files,
                                   const std::vector<std::string>& own = {}) const {
    OutputDirectory out(out_, own);
    for (const auto& [name, text] : files) out.write(name, text);
    return out.publish({{"status", "ok"}});
  }
  template <class Work>
  static void expect_error(const Work& work, const std::string& part) {
    try {
      work();
      FAIL() << "no error";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
};

TEST_F(OutputDirectoryTest, NothingAppearsBeforeTheResultIsWhole) {
  {
    const OutputDirectory out(out_);
    out.write("data.bin", "1");
    EXPECT_FALSE(fs::exists(out_ / "data.bin"));
  }
  EXPECT_FALSE(fs::exists(folder / "a"));  // not even the folder
  const std::string bytes("x\0y\n", 4);
  EXPECT_TRUE(publish({{"data.bin", bytes}, {"frames/1.png", "p"}}).empty());
  EXPECT_EQ(files(), (Files{{"data.bin", bytes}, {"frames/1.png", "p"}}));
  EXPECT_EQ(entries_of(folder / "a").size(), 1U);
}

TEST_F(OutputDirectoryTest, TheSummaryListsAllFilesWithTheirHashes) {
  publish({{"b.txt", "2"}, {"a.txt", "1"}});
  const auto list = summary()["files"];
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0]["path"], "a.txt");
  EXPECT_EQ(list[0]["sha256"], sha256_of_file(out_ / "a.txt"));
  EXPECT_EQ(list[1]["path"], "b.txt");
}

TEST_F(OutputDirectoryTest, NoFileOfAnOlderResultIsLeft) {
  publish({{"a.txt", "1"}, {"modes.csv", "1"}, {"frames/1.png", "1"}, {"frames/2.png", "1"}});
  publish({{"a.txt", "2"}, {"frames/1.png", "2"}});
  EXPECT_EQ(files(), (Files{{"a.txt", "2"}, {"frames/1.png", "2"}}));
  publish({{"b.txt", "3"}});
  EXPECT_EQ(files(), (Files{{"b.txt", "3"}}));
  EXPECT_FALSE(fs::exists(out_ / "frames"));
}

TEST_F(OutputDirectoryTest, FilesOfOthersStay) {
  publish({{"a.txt", "1"}, {"modes.csv", "1"}, {"frames/1.png", "1"}});
  write("a/out/notes.txt", "mine");
  write("a/out/frames/best.png", "mine");
  fs::create_directories(out_ / "empty");
  EXPECT_TRUE(publish({{"a.txt", "2"}}).empty());
  EXPECT_EQ(files(), (Files{{"a.txt", "2"}, {"notes.txt", "mine"}, {"frames/best.png", "mine"}}));
  EXPECT_TRUE(fs::exists(out_ / "empty"));
}

TEST_F(OutputDirectoryTest, AFileOfOthersInTheWayGetsAnotherName) {
  fs::create_directories(out_ / "a.txt" / "inner");
  write("a/out/b.txt", "mine");
  write("a/out/b.txt~", "mine, older");
  write("a/out/summary.json", "[1, 2]");
  const auto told = publish({{"a.txt", "1"}, {"b.txt", "1"}});
  ASSERT_EQ(told.size(), 3U);
  EXPECT_NE(told[1].find("b.txt~2"), std::string::npos) << told[1];
  EXPECT_EQ(files(), (Files{{"a.txt", "1"},
                            {"b.txt", "1"},
                            {"b.txt~", "mine, older"},
                            {"b.txt~2", "mine"},
                            {"summary.json~", "[1, 2]"}}));
  EXPECT_TRUE(fs::exists(out_ / "a.txt~" / "inner"));
  EXPECT_TRUE(publish({{"a.txt", "2"}}).empty());  // now they are our own
}

TEST_F(OutputDirectoryTest, ASummaryCannotHaveOtherFoldersCleared) {
  write("precious", "1");
  fs::create_directories(out_);
  write("a/out/summary.json",
        R"({"status": "ok", "files": [{"path": "../../precious"}, {"path": ")" + at("precious") +
            R"("}, {"path": 7}, 3]})");
  publish({{"a.txt", "1"}});
  EXPECT_EQ(read("precious"), "1");
}

TEST_F(OutputDirectoryTest, AResultWithoutAListIsReplacedByName) {
  fs::create_directories(out_);
  write("a/out/summary.json", R"({"status": "ok"})");
  write("a/out/a.txt", "1");
  write("a/out/other.txt", "1");
  EXPECT_TRUE(publish({{"a.txt", "2"}}).empty());
  EXPECT_EQ(files(), (Files{{"a.txt", "2"}, {"other.txt", "1"}}));
}

TEST_F(OutputDirectoryTest, LastingFilesOutlastResultsOfAnyProgram) {
  fs::create_directories(out_);
  write("a/out/results.csv", "rows");
  publish({{"results.csv", "rows in order"}, {"a.png", "1"}}, {"results.csv"});
  EXPECT_EQ(files(), (Files{{"results.csv", "rows in order"}, {"a.png", "1"}}));
  publish({{"map.png", "1"}});
  EXPECT_EQ(files(), (Files{{"results.csv", "rows in order"}, {"map.png", "1"}}));
}

TEST_F(OutputDirectoryTest, TwoProgramsCannotWriteTheSameFolder) {
  const OutputDirectory first(out_);
  expect_error([&] { const OutputDirectory second(out_); }, "out': ");
  expect_error([&] { const OutputDirectory second(out_); }, " is writing it");
}

TEST_F(OutputDirectoryTest, WorksInTheCurrentFolderAndThroughALink) {
  const fs::path before = fs::current_path();
  fs::create_directories(out_);
  fs::current_path(out_);
  {
    OutputDirectory out(".");
    out.write("a.txt", "1");
    out.publish({{"status", "ok"}});
    EXPECT_TRUE(fs::exists("a.txt"));  // the folder is still the one we are in
  }
  fs::current_path(before);
  fs::create_directory_symlink(out_, folder / "link");
  OutputDirectory out(folder / "link");
  out.write("b.txt", "2");
  out.publish({{"status", "ok"}});
  EXPECT_EQ(files(), (Files{{"b.txt", "2"}}));
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
}

TEST_F(OutputDirectoryTest, AFailedWriterIsNamedAndChangesNothing) {
  publish({{"f.txt", "old"}});
  {
    const OutputDirectory out(out_);
    out.save("p.png", [](const std::string& path) {
      EXPECT_EQ(fs::path(path).extension(), ".png");
      std::ofstream(path) << "x";
    });
    const auto half = [](const std::string& path) {
      std::ofstream(path) << "half";
      throw std::runtime_error("disk on fire");
    };
    expect_error([&] { out.save("f.txt", half); }, "out/f.txt': disk on fire");
    expect_error([&] { out.save("g.txt", [](const std::string&) {}); },
                 "out/g.txt': nothing was written");
  }
  EXPECT_EQ(files(), (Files{{"f.txt", "old"}}));
}

TEST_F(OutputDirectoryTest, RefusesNamesThatLeaveTheFolder) {
  const OutputDirectory out(out_);
  for (const char* name : {"", ".", "..", "../f", "sub/../../f", "/f"}) {
    EXPECT_THROW(out.write(name, "x"), Error) << name;
  }
}

TEST_F(OutputDirectoryTest, AFileInTheWayIsNamed) {
  write("file", "x");
  for (const fs::path& bad : {folder / "file", folder / "file" / "sub", fs::path("/proc/hybrid")}) {
    expect_error([&] { const OutputDirectory out(bad); }, bad.string());
  }
}

TEST(Sha256, MatchesThePublishedExamples) {
  const fs::path file = fs::temp_directory_path() / ("sha_" + std::to_string(::getpid()));
  const auto hash = [&](const std::string& text) {
    std::ofstream(file, std::ios::binary) << text;
    return sha256_of_file(file);
  };
  EXPECT_EQ(hash(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hash(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  fs::remove(file);
  EXPECT_THROW(sha256_of_file(file), SystemError);
}

TEST_F(OutputDirectoryTest, ASummaryIsAmendedAndTheRestStays) {
  publish({{"a.txt", "text"}});
  amend_summary(out_, "draws", {1, 2});
  EXPECT_EQ(summary().at("draws"), nlohmann::json({1, 2}));
  EXPECT_EQ(summary().at("status"), "ok");
  EXPECT_EQ(summary().at("files").size(), 1U);
  EXPECT_EQ(files(), (Files{{"a.txt", "text"}}));
  expect_error([&] { amend_summary(folder / "none", "draws", 1); }, "summary.json");
}

}  // namespace
}  // namespace hybrid
