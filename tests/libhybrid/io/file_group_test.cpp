// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/io/file_group.h"

#include <sys/stat.h>
#include <unistd.h>

#include <map>

#include "libhybrid/core/error.h"
#include "libhybrid/io/exchange_folders.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;
using Files = std::map<std::string, std::string>;

class FileGroupTest : public ScratchFolder {
 protected:
  /// All files of the folder, hidden ones too.
  Files files(const std::string& below = "") const {
    Files found;
    for (const std::string& name : files_below(folder / below)) {
      found[name] = read(below.empty() ? name : below + "/" + name);
    }
    return found;
  }
  static void stage(const FileGroup& group, const Files& files) {
    for (const auto& [name, text] : files) {
      FileWriter file(group.stage(name), group.target(name));
      file.write(text);
      file.close();
    }
  }
  void commit(const Files& files, const std::vector<std::string>& former = {}) const {
    FileGroup group(at("main"));
    stage(group, files);
    group.commit(former);
  }
  /// Expects that `work` throws an Error that holds `part`.
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

TEST_F(FileGroupTest, NothingIsSeenBeforeTheCommitAndNothingElseAfterIt) {
  write("main", "old");
  {
    FileGroup group(at("main"));
    stage(group, {{"main", "new"}, {"below/a", "1"}});
    EXPECT_EQ(read("main"), "old");
    EXPECT_FALSE(fs::exists(at("below")));
    EXPECT_EQ(group.staged(), (std::vector<std::string>{"below/a", "main"}));
  }
  EXPECT_EQ(files(), (Files{{"main", "old"}}));
  commit({{"main", "new"}, {"below/a", "1"}});
  EXPECT_EQ(files(), (Files{{"main", "new"}, {"below/a", "1"}}));
  EXPECT_EQ(entries_of(folder).size(), 2U);  // no empty folder either
}

TEST_F(FileGroupTest, FormerFilesGoWithTheirFolders) {
  commit({{"main", "1"}, {"a", "1"}, {"below/deep/b", "1"}});
  write("others", "stays");
  commit({{"main", "2"}, {"c", "2"}}, {"main", "a", "below/deep/b", "never there", "../others"});
  EXPECT_EQ(files(), (Files{{"main", "2"}, {"c", "2"}, {"others", "stays"}}));
  EXPECT_FALSE(fs::exists(at("below")));
}

TEST_F(FileGroupTest, AFailedCommitChangesNothing) {
  const Files old{{"a", "1"}, {"b", "1"}, {"main", "1"}, {"way", "is a file"}};
  for (const auto& [name, text] : old) write(name, text);
  fs::create_directories(at("folder/inner"));
  for (const char* bad : {"folder", "way/c"}) {
    expect_error(
        [&] {
          commit({{"a", "2"}, {bad, "2"}, {"main", "2"}, {"new", "2"}}, {"b"});
        },
        at(bad).substr(0, at(bad).rfind('/')));
    EXPECT_EQ(files(), old) << bad;
    EXPECT_TRUE(fs::exists(at("folder/inner")));
  }
  expect_error([&] { commit({{"a", "2"}}); }, "main': nothing was written");
  EXPECT_EQ(files(), old);
}

TEST_F(FileGroupTest, ACommitCanBeTakenBack) {
  commit({{"main", "1"}, {"a", "1"}});
  {
    FileGroup group(at("main"));
    stage(group, {{"main", "2"}, {"below/b", "2"}});
    group.commit({"a"});
    EXPECT_EQ(read("main"), "2");
    group.undo();
  }
  EXPECT_EQ(files(), (Files{{"main", "1"}, {"a", "1"}}));
  FileGroup group(at("main"));
  stage(group, {{"main", "3"}});
  group.commit();
  group.undo();
  EXPECT_EQ(read("main"), "1");
}

TEST_F(FileGroupTest, OneWriterAtATime) {
  FileGroup first(at("main"));
  expect_error([&] { const FileGroup second(at("main")); },
               "main': " + std::string(program_invocation_short_name) + " (process " +
                   std::to_string(::getpid()) + ") is writing it");
  expect_error([&] { const FileGroup second(at("main"), "the folder"); }, "'the folder'");
  const FileGroup other(at("other"));
  stage(first, {{"main", "1"}});
  first.commit();  // the second took nothing away
}

TEST_F(FileGroupTest, WhatADeadWriterLeftIsCleared) {
  fs::create_directories(at(".main.part/new/below"));
  fs::create_directories(at(".main.part/old"));
  write(".main.part/lock", "somebody");
  write(".main.part/new/below/stale", "half");
  write(".main.part/journal.part", "half");
  commit({{"main", "1"}});
  EXPECT_EQ(files(), (Files{{"main", "1"}}));
}

TEST_F(FileGroupTest, ACommitThatADeadWriterBeganIsCompletedFirst) {
  // It was killed when `a` and `main` had gone and `b` had come.
  const std::string journal("++main\0++a\0+-b\0+-c/d\0-+e\0", 25);
  fs::create_directories(at(".main.part/new/c"));
  fs::create_directories(at(".main.part/old"));
  write(".main.part/journal", journal);
  write(".main.part/old/main", "old");
  write(".main.part/old/a", "old");
  write(".main.part/new/main", "new");
  write(".main.part/new/a", "new");
  write(".main.part/new/c/d", "new");
  write("a", "old");
  write("b", "new");
  write("e", "old");
  { const FileGroup next(at("main")); }
  EXPECT_EQ(files(), (Files{{"main", "new"}, {"a", "new"}, {"b", "new"}, {"c/d", "new"}}));
}

TEST_F(FileGroupTest, AnUndoThatADeadWriterBeganIsCompletedFirst) {
  const std::string journal("++main\0++a\0+-b\0-+e\0", 19);
  fs::create_directories(at(".main.part/new"));
  fs::create_directories(at(".main.part/old"));
  write(".main.part/undo", journal);
  write(".main.part/old/main", "old");
  write(".main.part/new/main", "new");
  write("a", "old");  // was taken back already
  write("b", "new");
  write("e", "old");
  { const FileGroup next(at("main")); }
  EXPECT_EQ(files(), (Files{{"main", "old"}, {"a", "old"}, {"e", "old"}}));
}

TEST_F(FileGroupTest, AJournalOfSomebodyElseReachesNothingOutside) {
  write("victim", "precious");
  fs::create_directories(at("elsewhere"));
  write("elsewhere/file", "precious");
  const auto expect_untouched = [&] {
    const FileGroup next(at("out/main"));
    EXPECT_EQ(read("victim"), "precious");
    EXPECT_EQ(read("elsewhere/file"), "precious");
  };
  // Each name leaves the folder: by dots, as an absolute path, or through a link.
  const std::string absolute = at("victim");
  for (const std::string& name : {std::string("../victim"), absolute, std::string("d/file")}) {
    for (const char* journal : {"undo", "journal"}) {
      fs::create_directories(at("out/.main.part/new/d"));
      fs::create_directories(at("out/.main.part/old"));
      std::error_code ignored;
      fs::create_directory_symlink("../elsewhere", at("out/d"), ignored);
      write("out/.main.part/new/main", "new");
      write("out/.main.part/new/d/file", "evil");
      write("out/.main.part/victim", "evil");
      const std::string sign = journal == std::string("undo") ? "+-" : "++";
      write(std::string("out/.main.part/") + journal, sign + name + std::string("\0++main\0", 8));
      expect_untouched();
    }
  }
  // The folder of new files is a link itself.
  fs::create_directories(at("out/.main.part"));
  fs::create_directory_symlink("../../elsewhere", at("out/.main.part/new"));
  {
    FileGroup group(at("out/main"));
    stage(group, {{"main", "1"}, {"file", "evil"}});
    group.commit({"d/file"});
  }
  expect_untouched();
  FileGroup group(at("out/main"));
  expect_error([&] { group.stage("d/file"); }, "is a link");
}

TEST_F(FileGroupTest, FoldersThatItMadeGoWhereNothingIsCommitted) {
  { const FileGroup group(at("x/y/main")); }
  EXPECT_FALSE(fs::exists(at("x")));
  {
    FileGroup group(at("x/y/main"));
    stage(group, {{"main", "1"}});
    group.commit();
  }
  EXPECT_EQ(files(), (Files{{"x/y/main", "1"}}));
}

TEST_F(FileGroupTest, RefusesWhatIsNoFile) {
  fs::create_directories(at("taken"));
  expect_error([&] { const FileGroup group(at("taken")); }, "taken': is a folder");
  expect_error([&] { const FileGroup group(at("taken/")); }, "names no file");
  expect_error([] { const FileGroup group("/dev/null"); }, "/dev/null': is not a regular file");
  const FileGroup group(at("main"));
  for (const char* name : {"", ".", "..", "../f", "sub/../f", "/f", "sub/"}) {
    EXPECT_THROW(group.stage(name), Error) << name;
  }
}

TEST_F(FileGroupTest, ExchangesWholeFolders) {
  const auto write_group = [&](const Files& files, const std::vector<std::string>& former) {
    FileGroup group(at("out/main"));
    stage(group, files);
    return group.exchange(former);
  };
  fs::create_directories(at("out"));
  ::chmod(at("out").c_str(), 0750);
  ASSERT_TRUE(write_group({{"main", "1"}, {"below/a", "1"}}, {}));
  struct stat before = {}, after = {};
  ASSERT_EQ(::stat(at("out").c_str(), &before), 0);
  ASSERT_TRUE(write_group({{"main", "2"}, {"b", "2"}}, {"main", "below/a"}));
  ASSERT_EQ(::stat(at("out").c_str(), &after), 0);
  EXPECT_NE(before.st_ino, after.st_ino);
  EXPECT_EQ(after.st_mode & 0777U, 0750U);
  EXPECT_EQ(files(), (Files{{"out/main", "2"}, {"out/b", "2"}}));
  EXPECT_EQ(entries_of(folder).size(), 1U);
  // What appears while the folders change places is kept.
  FileGroup group(at("out/main"));
  stage(group, {{"main", "3"}});
  write("out/notes", "mine");
  ASSERT_TRUE(group.exchange({"main", "b"}));
  EXPECT_EQ(files(), (Files{{"out/main", "3"}, {"out/notes", "mine"}}));
}

TEST_F(FileGroupTest, TheCurrentFolderIsNotExchanged) {
  const fs::path before = fs::current_path();
  fs::current_path(folder);
  {
    FileGroup group("main");
    stage(group, {{"main", "1"}});
    EXPECT_FALSE(group.exchange({}));
    group.commit();
  }
  fs::current_path(before);
  EXPECT_EQ(files(), (Files{{"main", "1"}}));
}

TEST_F(FileGroupTest, WhatADeadWriterLeftBesideIsCleared) {
  fs::create_directories(at("out"));
  fs::create_directories(at(".out.part-Ab12Cd/below"));
  fs::create_directories(at(".out.part-longer_name"));
  fs::create_directories(at(".other.part-Ab12Cd"));
  remove_exchanged(at("out"));
  EXPECT_FALSE(fs::exists(at(".out.part-Ab12Cd")));
  EXPECT_TRUE(fs::exists(at(".out.part-longer_name")));
  EXPECT_TRUE(fs::exists(at(".other.part-Ab12Cd")));
}

TEST(FileWriter, AFullDeviceIsAnErrorWithItsName) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  try {
    FileWriter file("/dev/full", "shown");
    file.write(std::string(1 << 20, 'x'));
    file.close();
    FAIL() << "no error";
  } catch (const SystemError& e) {
    EXPECT_STREQ(e.what(), "cannot write 'shown': No space left on device");
    EXPECT_EQ(e.code(), ENOSPC);
  }
}

}  // namespace
}  // namespace hybrid
